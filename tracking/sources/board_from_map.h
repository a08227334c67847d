// The frame of a board of markers against a tracker's map that has a world and a unit of its own: a
// similarity, from frames that have both poses. Orientation from the orientations (mean of quaternions,
// Markley et al. 2007), scale and place from the centres, each pair weighed by how well the board gave it;
// again without those that do not fit. Good enough to move the map into the board's frame; there the board's
// corners, as known points of its adjustment, make it better than any number of pairs could
// (fiducial_observation.h).
#pragma once

#include <optional>
#include <vector>

#include "core/geometry/similarity3.h"
#include "tracking/sources/marker_locator.h"
#include "tracking/tracker/tracker.h"

namespace ulf::tracking {

class BoardFromMap {
 public:
  void Add(const Anchored& anchor, const MarkerPose& pose);
  void Clear() { pairs_.clear(); }
  // As the map stands now; none until there are pairs enough, far enough apart to tell the scale.
  std::optional<Similarity3> Fit(const Tracker& tracker) const;

 private:
  struct Pair {
    Anchored anchor;
    Rigid3 cam_from_board;
    double sigma = 0;
  };
  std::optional<Similarity3> Fit(const std::vector<Rigid3>& in_map, const std::vector<double>& weights) const;

  std::vector<Pair> pairs_;
};

}  // namespace ulf::tracking
