// Measures how bright the subject's image is, on a coarse grid of pixels inside its outline.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/image/image.h"

namespace ulf::coverage {

// Statistics of each pixel's brightest channel.
struct SubjectLight {
  double clipped_share = 0;  // at 99.5 % of full scale, display-encoded, or above
  // The values above which the brightest tenth and hundredth lie, display-encoded, 0 to 1.
  double brightest_tenth = 0, brightest_hundredth = 0;
  double mean_linear = 0;
};

// Returns none where the outline holds no pixel.
std::optional<SubjectLight> LightInside(const Image& image, const std::vector<Eigen::Vector2d>& outline);

}  // namespace ulf::coverage
