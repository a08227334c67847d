// Predicts a pose's error, and its quality from that.
//
// The error has three parts. The first is what the matches leave open: the covariance of the pose and its
// residuals (RefinePose). The second is what the map's points leave open: a point whose parallax is small has
// an uncertain depth, and noise, lens and shutter bend the map, which a frame cannot see because it fits the
// map it was found in. The third is the error that the map is known to have: how far later adjustments have
// moved the last keyframes since their poses were given. Checked against truth in docs/measured/tracking.md,
// "What the quality value says".
#pragma once

#include <deque>

#include "core/geometry/rigid3.h"
#include "tracking/map/anchored.h"
#include "tracking/map/map.h"

namespace ulf::tracking {

// Returns a quality from 0 to 1: one half where the camera's centre is predicted to be off by a hundredth of
// the distance of what it sees, near 1 where it is off by less.
double QualityOf(double center_sigma, double distance);
// Returns the inverse of QualityOf(): the predicted error of the centre as a share of the distance.
double ErrorShareOf(double quality);

// Returns how far the map may be bent where a frame sees it, as a share of the pose's own standard deviation:
// inversely proportional to the parallax of the points in view (median, radians). Measured on simulated
// scenes and drawn rooms.
double MapBend(double parallax);

// Estimates the map's error from how far the poses of its last keyframes have moved.
class MapDriftEstimate {
 public:
  // Adds a keyframe's pose as it was given.
  void Add(const Anchored& anchor, const Rigid3& cam_from_world);
  // Call it when a loop has moved everything at once, for good.
  void Clear() { given_.clear(); }
  // Returns the root mean square of how far the given poses have moved, for a camera that sees what lies at
  // `distance`; world units. The caller holds the map's lock.
  double CenterSigma(const Map& map, double distance) const;

 private:
  struct Given {
    Anchored anchor;
    Rigid3 cam_from_world;
  };
  std::deque<Given> given_;
};

}  // namespace ulf::tracking
