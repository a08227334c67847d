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

struct LightAtPointsOptions {
  int patch_px = 5;  // width of the average around a point. Guessed.
  // Darker or brighter light is not compared: it is mostly noise, or nearly clipped. Shares of full scale.
  // Guessed.
  float least_light = 0.01f, most_light = 0.9f;
};

class LightAtPoints {
 public:
  // Reads the view's image of most bits, and its `clipped` pixels (ReadViewLight). Throws Error if that
  // cannot be read.
  LightAtPoints(const LightField& light_field, const View& view, const LightAtPointsOptions& options = {},
                cv::Mat* clipped = nullptr);
  // Returns mean light above black, B G R; none if the patch leaves the picture, holds a nearly clipped
  // pixel, or is dark in any channel.
  std::optional<std::array<double, 3>> At(const Eigen::Vector2d& img) const;

 private:
  LightAtPointsOptions options_;
  double black_;
  cv::Mat light_;
};

// Pairs of places (px) in two views' images that show the same point.
using SharedPoints = std::vector<std::pair<Eigen::Vector2d, Eigen::Vector2d>>;
// Returns them by the other view's id; empty if the light field's points have no observations.
std::map<int, SharedPoints> PointsSharedWith(const LightField& light_field, int view_id);

}  // namespace ulf
