#include "coverage/simulated_operator/rows_by_eye.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>

#include "core/geometry/angles.h"

namespace ulf::coverage {
namespace {

using Eigen::Vector3d;

const Cap kUsualCap{Radians(60), Radians(40)};  // that a person fills where none is shown
constexpr double kUsualSpacing = 1.5;           // of an experienced person's rows, disc radii
constexpr double kVisibleHole = 0.5, kHoleSeenFromNear = 0.25;
constexpr double kGivesUpS = 5, kTriesAgainS = 20;

}  // namespace

// The painted cells, row by row.
class RowsByEye::SeenPaint {
 public:
  explicit SeenPaint(const ShownSphere& sphere) {
    for (const ShownSphere::Paint& paint : sphere.paint) {
      Row& row = rows_[paint.top];
      row.bottom = paint.bottom;
      row.right_of_left[paint.left] = paint.right;
    }
  }
  bool Holds(const CapFrame::Angles& at) const {
    const auto row = rows_.lower_bound(at.elevation);
    if (row == rows_.end() || row->second.bottom > at.elevation) return false;
    const auto run = row->second.right_of_left.upper_bound(at.azimuth);
    return run != row->second.right_of_left.begin() && std::prev(run)->second >= at.azimuth;
  }

 private:
  struct Row {
    double bottom = 0;
    std::map<double, double> right_of_left;
  };
  std::map<double, Row> rows_;  // by their upper edge
};

RowsByEye::RowsByEye(std::uint64_t seed, bool novice)
    : random_(seed * 1000003u + 31u),
      novice_(novice),
      own_spacing_(kUsualSpacing * Spread(novice ? 0.25 : 0.12)),
      wobble_(seed, 410, 3, 0.04, 0.25, novice ? 0.4 : 0.25) {}

double RowsByEye::Spread(double sigma) {
  double sum = -6;  // twelve uniform draws: the same on every platform
  for (int i = 0; i < 12; ++i) sum += static_cast<double>(random_() >> 11) * 0x1.0p-53;
  return std::exp(sigma * sum);
}

std::optional<CapFrame::Angles> RowsByEye::Toward(const ShownSphere& sphere, double time_s) {
  for (const ShownSphere::View& view : sphere.views)
    if (view.rim > 0) radius_ = view.rim;
  if (radius_ <= 0) return std::nullopt;
  const Cap cap = sphere.cap.value_or(kUsualCap);
  const double radius = radius_;
  const CapFrame::Angles at = sphere.frame.Of(sphere.toward_camera);
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
    // At the rim a person first moves up or down.
    const bool turning = std::abs(at.elevation - level_) > radius;
    const double azimuth =
        turning ? std::clamp(at.azimuth, -cap.width / 2, cap.width / 2)
                : (heading_ > 0 ? std::min(at.azimuth + ahead, to) : std::max(at.azimuth - ahead, to));
    return CapFrame::Angles{azimuth, std::clamp(level_ + radius * wobble_.At(time_s), -1.55, 1.55)};
  }
  const SeenPaint paint(sphere);
  std::erase_if(given_up_, [&](const Hole& hole) { return hole.seen_s < time_s - kTriesAgainS; });
  if (hole_) {
    const Vector3d direction = sphere.frame.Direction(hole_->at.azimuth, hole_->at.elevation);
    if (!sphere.Faces(direction) || !paint.Holds(hole_->at)) {
      if (time_s - hole_->seen_s < kGivesUpS + sphere.AngleFromDot(direction) / radius) return hole_->at;
      given_up_.push_back({hole_->at, time_s});
    }
    hole_.reset();
  }
  for (const double size : {kVisibleHole, kHoleSeenFromNear})
    if (const auto hole = FindHole(sphere, paint, size)) {
      hole_ = Hole{*hole, time_s};
      return hole;
    }
  return std::nullopt;
}

// Returns the nearest one on the side that faces the camera, by distances that are judged with an error.
std::optional<CapFrame::Angles> RowsByEye::FindHole(const ShownSphere& sphere, const SeenPaint& paint,
                                                    double size) {
  const Cap cap = sphere.cap.value_or(kUsualCap);
  const double step = size * radius_;
  const double right = cap.width / 2, top = cap.height / 2;
  const auto is_open = [&](double azimuth, double elevation) {
    return std::abs(azimuth) < right && std::abs(elevation) < top && !paint.Holds({azimuth, elevation});
  };
  std::optional<CapFrame::Angles> nearest;
  double least = std::numeric_limits<double>::infinity();
  for (double elevation = -top + 0.5 * step; elevation < top; elevation += step) {
    const double across = step / std::max(0.05, std::cos(elevation));
    for (double azimuth = -right + 0.5 * across; azimuth < right; azimuth += across) {
      if (!is_open(azimuth, elevation)) continue;
      const Vector3d direction = sphere.frame.Direction(azimuth, elevation);
      if (!sphere.Faces(direction)) continue;
      const int sides = is_open(azimuth - across / 2, elevation) + is_open(azimuth + across / 2, elevation) +
                        is_open(azimuth, elevation - step / 2) + is_open(azimuth, elevation + step / 2);
      if (sides < 2) continue;
      const bool given_up = std::ranges::any_of(given_up_, [&](const Hole& hole) {
        return sphere.frame.Direction(hole.at.azimuth, hole.at.elevation).dot(direction) >
               std::cos(0.5 * radius_);
      });
      const double away = sphere.AngleFromDot(direction) * Spread(0.15);
      if (given_up || away >= least) continue;
      least = away;
      nearest = {azimuth, elevation};
    }
  }
  return nearest;
}

}  // namespace ulf::coverage
