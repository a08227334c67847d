// Values by which other code refers to a map: they stay valid while the mapper changes it.
#pragma once

#include <Eigen/Core>
#include <string>

#include "core/geometry/rigid3.h"

namespace ulf::tracking {

// A pose relative to a keyframe, which it follows when the map changes: Map::PoseOf() gives its present
// value.
struct Anchored {
  int keyframe_id = -1;
  Rigid3 cam_from_keyframe;
  double unit = 1;  // Keyframe::unit when the pose was made
};

// A map point that an image shows, in pixels of the image as it is, with distortion and rolling shutter.
struct MapObservation {
  int point = -1;  // MapPoint::id
  Eigen::Vector2d img = Eigen::Vector2d::Zero();
  double sigma_px = 1;
};

// Why a stored map cannot be used.
enum class MapProblem {
  kUnusable,    // There is none, or it is unreadable, damaged or of another version.
  kOtherViews,  // It belongs to other views, poses or another working size.
};
struct MapRefusal {
  MapProblem problem = MapProblem::kUnusable;
  std::string words;  // for people
};

}  // namespace ulf::tracking
