// Detects that the covered share of the requested cap (coverage_map.h) no longer grows although the camera
// keeps moving round the subject: the rest may be out of reach (a wall, the floor, an arm's length). Reports
// it, with the largest gap and with the smaller cap that is covered.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>

#include "core/frames/frame.h"
#include "coverage/bound/coverage_map.h"

namespace ulf::coverage {

class CapWatch {
 public:
  // The capture ends when `share` (0 to 1) of the cap is covered. `turns`: the subject turns on a turntable,
  // and a whole turn without a gain is reported. `source`: pictures that are taken already get no advice for
  // the running capture.
  CapWatch(double share, bool turns, FrameSource source) : share_(share), turns_(turns), source_(source) {}
  // Call it after every frame that has a pose, with the camera's centre. `would_record`: the frame became a
  // view, or did not only because its direction is covered. Movement at other frames (pause, full disk, blur)
  // does not count. Returns a message for the operator, at most once until the covered share changes.
  std::optional<std::string> Update(const CoverageMap& map, const Eigen::Vector3d& center_in_world,
                                    bool would_record);

 private:
  const double share_;
  const bool turns_;
  const FrameSource source_;
  double most_covered_ = 0;
  std::optional<Eigen::Vector3d> from_;  // direction from the subject in which the present step began
  double moved_ = 0;                     // angle since the last gain, radians
  bool reported_ = false;
};

// Returns the largest cap with the same centre and about the same proportions as the map's, in whole degrees,
// of which at least `share` (0 to 1) is covered; none if that would be less than a degree wide or high, or if
// nothing is recorded.
std::optional<Cap> LargestCovered(const CoverageMap& map, double share);

}  // namespace ulf::coverage
