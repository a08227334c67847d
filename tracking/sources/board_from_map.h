// Fits the similarity from a tracker's map, which has a world and a unit of its own, to a board's frame
// (metres), from frames that have both poses. Orientations give the rotation (mean of quaternions, Markley et
// al. 2007), centres give scale and translation. Each pair is weighted by the board pose's uncertainty;
// further rounds weigh pairs that do not fit less. The fit is good enough to move the map into the board's
// frame; there the board's corners, as known points of the adjustment, make it better than more pairs could
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
  // Fits to the map's present poses. Returns none until enough pairs, far enough apart, determine the scale.
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
