// The frame of a board of markers against a tracker's map, which has a world and a unit of its own: a
// similarity, from frames that have both poses. Orientation from the orientations (mean of quaternions,
// Markley et al. 2007), scale and place from the centres, each pair weighed by how well the board gave it;
// again without those that do not fit. A board's single pose is noisy, the map's poses are good among
// themselves: many pairs make the frame better than any of them.
#pragma once

#include <optional>
#include <vector>

#include "tracking/marker_locator.h"
#include "tracking/tracker.h"
#include "tracking/trajectory.h"

namespace ulf {

class BoardFromMap {
 public:
  void Add(const Anchored& anchor, const MarkerPose& pose);
  void Clear() { *this = {}; }
  std::size_t Pairs() const { return pairs_.size(); }
  // As the map stands now. Known() once there are pairs enough with a baseline between them.
  void Update(const Tracker& tracker);
  bool Known() const { return known_; }
  // The map is in the board's frame, for good.
  void Hold() { known_ = held_ = true; }

  Rigid3 ToBoard(const Rigid3& cam_from_map) const;
  Rigid3 ToMap(const Rigid3& cam_from_board) const;
  Eigen::Vector3d ToBoard(const Eigen::Vector3d& point_in_map) const {
    return board_from_map_ * point_in_map;
  }
  double Scale() const { return board_from_map_.scale; }

 private:
  struct Pair {
    Anchored anchor;
    Rigid3 cam_from_board;
    double sigma = 0, distance = 0;
  };
  std::optional<Similarity3> Fit(const std::vector<Rigid3>& in_map, const std::vector<double>& weights) const;

  std::vector<Pair> pairs_;
  bool known_ = false, held_ = false;
  Similarity3 board_from_map_;
};

}  // namespace ulf
