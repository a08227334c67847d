// Makes Gaussians of a light field without training: places and shapes come from the depth maps of its views
// (placing.h), colours from least squares over its photographs (color_fit.h).
#pragma once

#include <cstddef>
#include <functional>
#include <string>

#include "render/scene/scene.h"
#include "render/splats/gaussians.h"

namespace ulf::render {

struct SplatOptions {
  std::size_t most = 1000000;  // Gaussians
  int views = 96;              // that are used, spread over all. Guessed.
  double most_px = 75e6;       // of their pictures together; larger photographs are reduced. Guessed.
  std::function<void(double share, const std::string& what)> progress = {};  // may throw to stop
};

struct Splats {
  Gaussians gaussians;
  std::size_t around = 0;  // of them on the sphere around all
  int views = 0;           // that were used
  double psnr_db = 0;      // of the pictures of these views, before the last correction
};

// The scene's proxy must have a mesh, and best the views' depth maps. Throws Error if nothing can be placed.
Splats MakeSplats(const RenderScene& scene, const SplatOptions& options);

}  // namespace ulf::render
