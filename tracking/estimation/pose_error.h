// Predicts a pose's error, and its quality from that.
//
// The error has two parts: what the matches leave open (the covariance of the pose and its residuals;
// RefinePose), and the map's own error, which a frame cannot see because it fits the map it was found in. The
// second part is measured by what later adjustments do to poses already given: how far the last keyframes
// have moved since. A map that still moves is wrong by about as much. Checked against truth in
// docs/tracking_measured.md, "What the quality value says".
#pragma once

#include <deque>

#include "core/geometry/rigid3.h"
#include "tracking/map/anchored.h"
#include "tracking/map/map.h"

namespace ulf::tracking {

// 0 to 1: one half where the camera's centre is predicted to be off by a hundredth of the distance of what it
// sees, near 1 where by less.
double QualityOf(double center_sigma, double distance);

// Guessed.
struct MapDriftOptions {
  std::size_t keyframes = 10;  // the newest, whose moves are measured: fewer jump, more report old moves
  // Before the map has been adjusted: the expected move, as a share of the distance, and the number of
  // keyframes that it counts as.
  double young_share = 0.00015, young_counts = 2;
};

class MapDriftEstimate {
 public:
  explicit MapDriftEstimate(const MapDriftOptions& options = {}) : options_(options) {}
  // Adds a keyframe's pose as it was given.
  void Add(const Anchored& anchor, const Rigid3& cam_from_world);
  // Call it when a loop has moved everything at once, for good.
  void Clear() { given_.clear(); }
  // Root mean square of how far the given poses have moved, for a camera that sees what lies at `distance`;
  // world units. Reads the map: the caller holds its lock.
  double CenterSigma(const Map& map, double distance) const;

 private:
  struct Given {
    Anchored anchor;
    Rigid3 cam_from_world;
  };
  MapDriftOptions options_;
  std::deque<Given> given_;
};

}  // namespace ulf::tracking
