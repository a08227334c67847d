#include "tracking/sources/pose_history.h"

#include <algorithm>
#include <cmath>

namespace ulf::tracking {

std::optional<Rigid3> PoseFromNumbers(std::span<const double, 7> v) {
  constexpr double kUnitTolerance = 0.05;  // of the quaternion's length. Guessed
  const Eigen::Quaterniond rotation(v[6], v[3], v[4], v[5]);
  if (!std::ranges::all_of(v, [](double number) { return std::isfinite(number); }) ||
      std::abs(rotation.norm() - 1) > kUnitTolerance)
    return std::nullopt;
  return Rigid3{rotation.normalized(), {v[0], v[1], v[2]}};
}

void PoseHistory::Add(double time_s, const Rigid3& world_from_body) {
  poses_[time_s] = world_from_body;
  if (poses_.size() > most_) poses_.erase(poses_.begin());
}

PoseLookup PoseHistory::At(double time_s, Rigid3* world_from_body) const {
  const auto after = poses_.lower_bound(time_s);
  if (after == poses_.end()) return PoseLookup::kAfter;
  if (after->first == time_s) {
    *world_from_body = after->second;
    return PoseLookup::kFound;
  }
  if (after == poses_.begin()) return PoseLookup::kBefore;
  const auto before = std::prev(after);
  const double gap_s = after->first - before->first;
  if (gap_s > max_gap_s_) return PoseLookup::kGap;
  const double share = (time_s - before->first) / gap_s;
  world_from_body->rotation = before->second.rotation.slerp(share, after->second.rotation);
  world_from_body->translation = (1 - share) * before->second.translation + share * after->second.translation;
  return PoseLookup::kFound;
}

}  // namespace ulf::tracking
