// Predicts a pose's error, and its quality from that.
//
// The error has three parts: what the matches leave open (RefinePose()'s `center_sigma`); what the map's
// points leave open (MapBend()), because depths are uncertain, and noise, lens and shutter bend the map,
// which a frame that was found in it cannot see; and the error that the map is known to have
// (MapDriftEstimate): how far later adjustments have moved the last keyframes since their poses were given.
// The prediction is compared with truth in docs/measured/tracking.md, "What the quality value says".
#pragma once

#include <deque>

#include "core/geometry/rigid3.h"
#include "tracking/map/anchored.h"
#include "tracking/map/map.h"

namespace ulf::tracking {

// Returns a quality from 0 to 1: one half if the camera's centre is predicted to be off by a hundredth of the
// distance of what it sees, near 1 if it is off by less. Both are in world units.
double QualityOf(double center_sigma, double distance);
// Returns the predicted error of the centre, as a share of the distance, that gives a quality; 10 at most.
double ErrorShareOf(double quality);

// Returns the error of the centre by a bent map in units of the pose's own standard deviation, from the
// median parallax of the points in view, radians. Measured on simulated scenes and drawn rooms.
double MapBend(double parallax);

// Estimates the map's error from how far the poses of its last keyframes have moved.
class MapDriftEstimate {
 public:
  // Adds the pose of a frame that became a keyframe, as it was given to users, and its anchor.
  void Add(const Anchored& anchor, const Rigid3& cam_from_world);
  // Call it when a loop has moved everything at once, for good.
  void Clear() { given_.clear(); }
  // Returns the root mean square of how far the last given poses have moved, world units, with what is usual
  // at `distance` while there are few. The caller holds the map's lock.
  double CenterSigma(const Map& map, double distance) const;

 private:
  struct Given {
    Anchored anchor;
    Rigid3 cam_from_world;
  };
  std::deque<Given> given_;
};

}  // namespace ulf::tracking
