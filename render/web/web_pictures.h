// Converts the photographs of a light field to pictures for a page: without distortion, on one scale of light
// (exposures, gains and fall-offs divided out), in sRGB, as WebP, each in two sizes. Size and quality follow
// from the allowed bytes.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "render/scene/scene.h"

namespace ulf::render {

struct WebPictureOptions {
  std::size_t most_bytes = 0;  // of all pictures together, both sizes, before base64
  // Longer side: a phone keeps some dozens of such pictures in 150 MB of textures.
  int longest_px = 1280;
  std::function<void(double share, const std::string& what)> progress = {};
  std::function<bool()> stop = {};  // polled; if true, throws Error
};

struct WebPicture {
  CameraModel camera;       // undistorted, of the size of `fine`
  std::string fine, small;  // WebP
  bool has_gaps = false;    // alpha is 0 where the photograph has no light (masks)
};

// The fine pictures are this many times as wide and high as the small ones.
inline constexpr int kSmallWebPictureDivisor = 4;

// Bytes of a view's two pictures, of 64 px and a quarter of that, at the least quality: fewer than the mean
// of any set that was measured (docs/web_page.md).
inline constexpr std::size_t kLeastWebPicture = 400;

struct WebPictures {
  std::vector<WebPicture> views;  // in the scene's order
  int quality = 0;                // WebP's quality of the fine ones, 1 to 100; of some it is one higher
  std::size_t bytes = 0;
};

// Uses at least 95 % of the bytes, unless the photographs' own size and the best quality need fewer. Throws
// Refusal that says how many are needed if they do not suffice, Error if a photograph cannot be read.
WebPictures MakeWebPictures(const RenderScene& scene, const WebPictureOptions& options);

}  // namespace ulf::render
