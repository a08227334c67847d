// Depth maps of several views made into one set of points: a depth counts where the maps of other views say
// the same, and is then their mean; what several views saw becomes one point that knows them.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "render/stereo/plane_sweep.h"

namespace ulf::render {

struct ViewDepth {
  StereoView view;
  cv::Mat depth;          // CV_32F, along the optical axis; 0: none
  double plane_step = 0;  // of the sweep, in inverse depth: how far two maps may differ
};

struct FusedPoint {
  Eigen::Vector3d position_in_world = Eigen::Vector3d::Zero();
  double spread = 0;                   // world units: one plane of the sweep
  double pixel = 0;                    // world units: as large as a pixel of its own view there
  std::vector<std::uint16_t> seen_by;  // indices of ViewDepth, its own first
};

struct FusionOptions {
  int agreeing_views = 2;  // others, at least, whose maps say the same
  double tolerance_planes = 1.0;
  int spacing_px = 2;  // between points, in the views' pixels
};

// In place: depths that too few other maps confirm become 0, the others the mean of what the maps say.
// `others[i]` are the views whose maps are asked about view i.
void KeepWhatAgrees(std::vector<ViewDepth>& views, const std::vector<std::vector<int>>& others,
                    const FusionOptions& options);

// Of maps that agree. Views are taken in their order.
std::vector<FusedPoint> FusePoints(const std::vector<ViewDepth>& views,
                                   const std::vector<std::vector<int>>& others, const FusionOptions& options);

}  // namespace ulf::render
