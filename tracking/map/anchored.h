// Values that refer to a map and stay valid while the mapper changes it.
#pragma once

#include <Eigen/Core>

#include "core/geometry/rigid3.h"

namespace ulf::tracking {

// A pose relative to a keyframe, which later adjustments may move.
struct Anchored {
  int keyframe_id = -1;
  Rigid3 cam_from_keyframe;
  // The keyframe's unit when the pose was made: a closed loop scales lengths, and this pose's with them.
  double unit = 1;
};

// A map point that an image shows, and where: pixels of the image as it is, with distortion and rolling
// shutter.
struct MapObservation {
  int point = -1;
  Eigen::Vector2d img = Eigen::Vector2d::Zero();
  double sigma_px = 1;
};

}  // namespace ulf::tracking
