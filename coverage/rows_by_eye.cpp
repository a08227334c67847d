#include "coverage/rows_by_eye.h"

#include <algorithm>
#include <cmath>

namespace ulf {
namespace {

using Eigen::Vector3d;

// Who wants a cap but was told none has this in mind.
const Cap kUsualCap{60 * M_PI / 180, 40 * M_PI / 180};
constexpr double kUsualSpacing = 1.5;  // what an experienced person aims at, in disc radii
constexpr double kVisibleHole = 0.5, kHoleSeenFromNear = 0.25;
constexpr double kGivesUpS = 5, kTriesAgainS = 20;

}  // namespace

RowsByEye::RowsByEye(std::uint64_t seed, bool novice)
    : random_(seed * 1000003u + 31u),
      novice_(novice),
      own_spacing_(kUsualSpacing * Spread(novice ? 0.25 : 0.12)),
      wobble_(seed, 410, 3, 0.04, 0.25, novice ? 0.4 : 0.25) {}

// A factor about one.
double RowsByEye::Spread(double sigma) {
  double sum = -6;  // twelve uniform draws: the same on every platform
  for (int i = 0; i < 12; ++i) sum += static_cast<double>(random_() >> 11) * 0x1.0p-53;
  return std::exp(sigma * sum);
}

std::optional<Vector3d> RowsByEye::Toward(const CoverageMap& map, const Vector3d& hand, double time_s) {
  const CapFrame& frame = *map.frame();
  const Cap cap = map.options().cap.value_or(kUsualCap);
  const double radius = map.spacing() * map.options().cells_per_disc_radius;
  const CapFrame::Angles at = frame.Of(hand);
  if (upwards_ == 0) {
    upwards_ = Spread(1) > 1 ? 1 : -1;
    heading_ = at.azimuth > 0 ? -1 : 1;
    level_ = -upwards_ * std::max(0.0, cap.height / 2 - 0.5 * own_spacing_ * radius);
  }
  if (!rows_done_) {
    const double rim = heading_ * (cap.width / 2 - 0.4 * radius);
    const bool on_the_row = std::abs(at.elevation - level_) < radius;
    if (on_the_row && heading_ * (at.azimuth - rim) >= 0) {
      heading_ = -heading_;
      level_ += upwards_ * radius * own_spacing_ * Spread(novice_ ? 0.2 : 0.12);
      rows_done_ = std::abs(level_) > cap.height / 2 + 0.2 * radius && level_ * upwards_ > 0;
    }
  }
  if (!rows_done_) {
    const double ahead = 4 * radius / std::cos(at.elevation);
    const double to = heading_ * (cap.width / 2 + 0.5 * radius);
    // Up or down at the rim first, as one does.
    const bool turning = std::abs(at.elevation - level_) > radius;
    const double azimuth =
        turning ? std::clamp(at.azimuth, -cap.width / 2, cap.width / 2)
                : (heading_ > 0 ? std::min(at.azimuth + ahead, to) : std::max(at.azimuth - ahead, to));
    return frame.Direction(azimuth, std::clamp(level_ + radius * wobble_.At(time_s), -1.55, 1.55));
  }
  std::erase_if(given_up_, [&](const Hole& hole) { return hole.seen_s < time_s - kTriesAgainS; });
  if (hole_) {
    const auto covering = map.At(hole_->direction);
    if (covering && covering->index < 0) {
      if (time_s - hole_->seen_s < kGivesUpS + hand.cross(hole_->direction).norm() / radius)
        return hole_->direction;
      given_up_.push_back({hole_->direction, time_s});
    }
    hole_.reset();
  }
  for (const double size : {kVisibleHole, kHoleSeenFromNear})
    if (const auto hole = FindHole(map, hand, size)) {
      hole_ = Hole{*hole, time_s};
      return hole;
    }
  return std::nullopt;
}

// The nearest one, as far as one can judge it.
std::optional<Vector3d> RowsByEye::FindHole(const CoverageMap& map, const Vector3d& hand, double size) {
  const CapFrame& frame = *map.frame();
  const Cap cap = map.options().cap.value_or(kUsualCap);
  const double radius = map.spacing() * map.options().cells_per_disc_radius;
  const double step = size * radius;
  const auto is_open = [&](double azimuth, double elevation) {
    const auto covering = map.At(frame.Direction(azimuth, elevation));
    return covering && covering->index < 0;
  };
  std::optional<Vector3d> nearest;
  double least = std::numeric_limits<double>::infinity();
  for (double elevation = -cap.height / 2 + 0.5 * step; elevation < cap.height / 2; elevation += step) {
    const double across = step / std::max(0.05, std::cos(elevation));
    for (double azimuth = -cap.width / 2 + 0.5 * across; azimuth < cap.width / 2; azimuth += across) {
      if (!is_open(azimuth, elevation)) continue;
      const int sides = is_open(azimuth - across / 2, elevation) + is_open(azimuth + across / 2, elevation) +
                        is_open(azimuth, elevation - step / 2) + is_open(azimuth, elevation + step / 2);
      if (sides < 2) continue;
      const Vector3d direction = frame.Direction(azimuth, elevation);
      const bool given_up = std::any_of(given_up_.begin(), given_up_.end(), [&](const Hole& hole) {
        return hole.direction.dot(direction) > std::cos(0.5 * radius);
      });
      const double away = std::acos(std::clamp(direction.dot(hand), -1.0, 1.0)) * Spread(0.15);
      if (given_up || away >= least) continue;
      least = away;
      nearest = direction;
    }
  }
  return nearest;
}

}  // namespace ulf
