// Keeps poses with times, as a robot or a motion-capture system sends them, and interpolates between two: the
// position on the line, the orientation on the shortest arc. In a gap there is no pose.
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <span>

#include "core/geometry/rigid3.h"

namespace ulf::tracking {

// kBefore and kAfter: the moment is before the oldest pose, or after the newest.
enum class PoseLookup { kFound, kBefore, kAfter, kGap };

// Returns a pose from the numbers tx ty tz qx qy qz qw; none unless finite, with a quaternion of length 1.
std::optional<Rigid3> PoseFromNumbers(std::span<const double, 7> numbers);

class PoseHistory {
 public:
  // Between two poses that are farther apart than `max_gap_s` is a gap. Keeps the latest `most` poses.
  explicit PoseHistory(double max_gap_s, std::size_t most = std::size_t(-1))
      : max_gap_s_(max_gap_s), most_(most) {}

  // Poses may come in any order; a second pose of one time replaces the first.
  void Add(double time_s, const Rigid3& world_from_body);
  PoseLookup At(double time_s, Rigid3* world_from_body) const;  // sets the pose for kFound
  bool empty() const { return poses_.empty(); }
  double NewestS() const { return poses_.empty() ? 0 : poses_.rbegin()->first; }  // time of the newest pose

 private:
  double max_gap_s_;
  std::size_t most_;
  std::map<double, Rigid3> poses_;
};

}  // namespace ulf::tracking
