// Gives the photographs of a light field one even light, as renderings blend it, for programs that expect it:
// divided by the flat field, in linear sRGB by the colour profile, and at the exposure of the median
// photograph. Where no exposure is known, brightness, white balance and vignetting are those that the
// photographs themselves show on the light field's mesh (light_fit.h).
#pragma once

#include <atomic>
#include <cstddef>
#include <map>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "core/light_field/light_field.h"
#include "render/scene/scene.h"

namespace ulf::render {

class EvenedLight {
 public:
  // `light_field` must outlive it. Reads photographs where exposures must be estimated.
  explicit EvenedLight(const LightField& light_field);

  // Returns the photograph's light, CV_32FC3, linear, of its camera's size. Several threads may call it.
  // Throws Error if the photograph cannot be read.
  cv::Mat Of(const View& view) const;

  // Returns sentences on what was done, and on what could not be.
  std::vector<std::string> Words() const;

 private:
  void FitOnMesh();

  const LightField& light_field_;
  std::map<int, SceneView> views_;  // by id; what OnCommonScale() needs
  float most_scale_ = 1;
  std::string words_;
  std::vector<int> unmatched_;  // ids of views whose exposure remains unknown
  // Numbers of pixels: all, and those that were full in a photograph that others outlast.
  mutable std::atomic<std::size_t> pixels_ = 0, full_ = 0;
};

}  // namespace ulf::render
