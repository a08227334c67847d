// Fuses the depth maps of several views into one set of points. A depth is kept if enough maps of other views
// agree with it, and more than see through it; it becomes the mean (in inverse depth) of what agrees. A
// surface point seen by several views becomes one point with a list of these views.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "render/stereo/plane_sweep.h"

namespace ulf::render {

struct ViewDepth {
  StereoView view;
  cv::Mat depth;          // CV_32F, along the optical axis, world units; 0: none
  double plane_step = 0;  // inverse depth between planes of the sweep; scales FusionOptions::tolerance_planes
};

struct FusedPoint {
  Eigen::Vector3d position_in_world = Eigen::Vector3d::Zero();
  double spread = 0;                   // world units: the distance of two planes of the sweep there
  double pixel = 0;                    // world units: the size of a pixel of its own view there
  std::vector<std::uint16_t> seen_by;  // indices of ViewDepth, its own view first
};

struct FusionOptions {
  int agreeing_views = 2;         // a depth needs this many other maps that agree. Guessed.
  double tolerance_planes = 1.0;  // two maps agree up to this difference, in planes of the sweep. Guessed.
  int spacing_px = 2;             // px of its view: least distance of points of one view. Guessed.
  bool in_this_thread = false;    // otherwise on all processors
};

// Sets depths that other maps do not confirm to 0, and the others to the mean of the maps that agree.
// `others[i]` are the indices of the views whose maps are compared with that of views[i].
void KeepConsistentDepths(std::vector<ViewDepth>& views, const std::vector<std::vector<int>>& others,
                          const FusionOptions& options);

// Returns the points of the maps after KeepConsistentDepths(), view by view.
std::vector<FusedPoint> FusePoints(const std::vector<ViewDepth>& views,
                                   const std::vector<std::vector<int>>& others, const FusionOptions& options);

}  // namespace ulf::render
