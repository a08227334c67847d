// Values by which others refer to a map: they stay valid while the mapper changes it.
#pragma once

#include <Eigen/Core>
#include <string>

#include "core/geometry/rigid3.h"

namespace ulf::tracking {

// A pose relative to a keyframe, which later adjustments may move.
struct Anchored {
  int keyframe_id = -1;
  Rigid3 cam_from_keyframe;
  // The keyframe's unit when the pose was made: a closed loop scales lengths, and this pose's with them.
  double unit = 1;
};

// A map point that an image shows, in pixels of the image as it is, with distortion and rolling shutter.
struct MapObservation {
  int point = -1;
  Eigen::Vector2d img = Eigen::Vector2d::Zero();
  double sigma_px = 1;
};

// Why a stored map cannot be used.
enum class MapProblem {
  kUnusable,    // there is none, or it is unreadable, damaged or of another version
  kOtherViews,  // it has another key: it belongs to other views, poses or another working size
};
struct MapRefusal {
  MapProblem problem = MapProblem::kUnusable;
  std::string words;  // for people
};

}  // namespace ulf::tracking
