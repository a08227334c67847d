// Poses with times, as a robot or a motion-capture system sends them, and interpolation between two: the
// position on the line, the orientation on the shortest arc. In a gap there is no pose.
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <span>

#include "core/geometry/rigid3.h"

namespace ulf::tracking {

enum class PoseLookup { kFound, kBefore, kAfter, kGap };  // kAfter: the moment is after the newest pose

// Returns a pose from the numbers tx ty tz qx qy qz qw; none where they are not finite or hold no rotation.
std::optional<Rigid3> PoseFromNumbers(std::span<const double, 7> numbers);

class PoseHistory {
 public:
  // No pose lies between two that are farther apart than `max_gap_s`. The latest `most` poses are kept.
  explicit PoseHistory(double max_gap_s, std::size_t most = std::size_t(-1))
      : max_gap_s_(max_gap_s), most_(most) {}

  // Poses may come in any order; a second pose of one time replaces the first.
  void Add(double time_s, const Rigid3& world_from_body);
  PoseLookup At(double time_s, Rigid3* world_from_body) const;
  bool empty() const { return poses_.empty(); }
  double NewestS() const { return poses_.empty() ? 0 : poses_.rbegin()->first; }

 private:
  double max_gap_s_;
  std::size_t most_;
  std::map<double, Rigid3> poses_;
};

}  // namespace ulf::tracking
