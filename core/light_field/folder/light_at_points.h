// Reads the light of a view's photograph around scene points, for comparing views with each other.
#pragma once

#include <Eigen/Core>
#include <array>
#include <map>
#include <opencv2/core.hpp>
#include <optional>
#include <utility>
#include <vector>

#include "core/light_field/light_field.h"

namespace ulf {

class LightAtPoints {
 public:
  // Reads the view's image of highest dynamic range; `clipped` receives its clipped pixels in the form of
  // ReadViewLight(). Throws Error if the image cannot be read.
  LightAtPoints(const LightField& light_field, const View& view, cv::Mat* clipped = nullptr);
  // Returns the mean linear light above black around `img` (pixels of the recorded image): B G R, shares of
  // full scale; none if the patch leaves the image, holds a nearly clipped pixel, or is dark in any channel.
  std::optional<std::array<double, 3>> At(const Eigen::Vector2d& img) const;

 private:
  double black_;
  cv::Mat light_;
};

// Pairs of places (px) in two views' recorded images that show the same point.
using SharedPoints = std::vector<std::pair<Eigen::Vector2d, Eigen::Vector2d>>;
// Returns the pairs (place in the view, place in the other view) by the other view's id; empty if the light
// field's points have no observations.
std::map<int, SharedPoints> PointsSharedWith(const LightField& light_field, int view_id);

}  // namespace ulf
