// What error a given pose is predicted to have, and its quality.
//
// Two things make it: what the matches leave open (the covariance of the pose, its residuals; RefinePose),
// and what the map itself is wrong by, which a frame cannot see: it fits the map it was found in. That part
// is measured by what later adjustments do to poses already given: how far the last keyframes lie from where
// they were when they were given. A map that still moves is wrong by about as much. Checked against truth in
// docs/tracking_measured.md.
#pragma once

#include <deque>

#include "core/geometry/rigid3.h"
#include "tracking/map/anchored.h"
#include "tracking/map/map.h"

namespace ulf::tracking {

// One half where the camera's centre is predicted to be off by a hundredth of the distance of what it sees,
// near 1 where by less.
double QualityOf(double center_sigma, double distance);

class MapDriftEstimate {
 public:
  // A keyframe's pose as it was given.
  void Give(const Anchored& anchor, const Rigid3& cam_from_world);
  // A loop moved everything at once, and for good.
  void Forget() { given_.clear(); }
  // How far poses that were given have turned out to be off, root mean square, of cameras that see what lies
  // at `distance`; world units. The map is read: hold its lock.
  double Of(const Map& map, double distance) const;

 private:
  static constexpr std::size_t kRecent = 10;
  struct Given {
    Anchored anchor;
    Rigid3 cam_from_world;
  };
  std::deque<Given> given_;
};

}  // namespace ulf::tracking
