// Fits the similarity from a tracker's map, which has a world and a unit of its own, to the frame of a board
// or of markers (metres), from frames that have poses in both. Orientations give the rotation (mean of
// quaternions, Markley et al. 2007), centres give scale and translation. Each pair is weighted by the board
// pose's uncertainty; further rounds weigh pairs that do not fit less. The fit is good enough to move the map
// into the board's frame; there the board's corners, as known points of the adjustment, make it better than
// more pairs could (fiducial_observation.h).
#pragma once

#include <optional>
#include <vector>

#include "core/geometry/similarity3.h"
#include "tracking/sources/marker_locator.h"
#include "tracking/tracker/tracker.h"

namespace ulf::tracking {

class BoardFromMap {
 public:
  // Adds one frame's pose in the map and by the board.
  void Add(const Anchored& anchor, const MarkerPose& pose);
  void Clear() { pairs_.clear(); }  // call it when the map was replaced
  // Returns board_from_map for the map's present poses; none until the pairs determine the scale to 5 %.
  std::optional<Similarity3> Fit(const Tracker& tracker) const;

 private:
  struct Pair {
    Anchored anchor;
    Rigid3 cam_from_board;
    double sigma = 0;  // of the board pose's centre, metres
  };
  std::optional<Similarity3> Fit(const std::vector<Rigid3>& in_map, const std::vector<double>& weights) const;

  std::vector<Pair> pairs_;
};

}  // namespace ulf::tracking
