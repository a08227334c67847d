// Measures how bright the subject's image is, on a coarse grid of pixels.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/image/image.h"

namespace ulf::coverage {

// Statistics of each pixel's brightest channel, 0 to 1. Display-encoded means by the curve of sRGB.
struct SubjectLight {
  double clipped_share = 0;  // of the pixels: at 0.995, display-encoded, or above
  // The values above which the brightest tenth and hundredth lie, display-encoded.
  double brightest_tenth = 0, brightest_hundredth = 0;
  double mean_linear = 0;  // in linear light
};

// Returns the light within the ellipse that fills the bounding box of `outline` (corners in pixels, not
// empty); beyond the frame its nearest pixels count. Returns none for a box without area.
std::optional<SubjectLight> LightInside(const Image& image, const std::vector<Eigen::Vector2d>& outline);

}  // namespace ulf::coverage
