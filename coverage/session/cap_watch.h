// Detects that the requested cap no longer fills although the camera keeps moving round the subject: the rest
// may be out of reach (a wall, the floor, an arm's length). Reports it once, with what is open and with the
// smaller cap that is covered.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>

#include "core/frames/frame.h"
#include "coverage/bound/coverage_map.h"

namespace ulf::coverage {

class CapWatch {
 public:
  // `share` of the cap ends the capture. `turns`: the subject turns before a fixed camera; then only whole
  // turns without a gain count. `source`: advice to move is given only for a camera in the hand.
  CapWatch(double share, bool turns, FrameSource source) : share_(share), turns_(turns), source_(source) {}
  // Call after every frame with a pose. `would_record`: only coverage decided whether the frame became a view
  // (not a pause, a full disk, blur); only then movement without a gain counts. Returns a line for the
  // operator, at most once between two gains.
  std::optional<std::string> Update(const CoverageMap& map, const Eigen::Vector3d& center_in_world,
                                    bool would_record);

 private:
  const double share_;
  const bool turns_;
  const FrameSource source_;
  double most_covered_ = 0;
  std::optional<Eigen::Vector3d> from_;  // where the present step began
  double moved_ = 0;                     // since the last gain, radians
  bool reported_ = false;
};

// Returns the largest cap of the same shape and middle, in whole degrees, of which at least `share` is
// covered; none if not even one of a degree.
std::optional<Cap> LargestCovered(const CoverageMap& map, double share);

}  // namespace ulf::coverage
