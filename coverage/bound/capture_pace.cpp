#include "coverage/bound/capture_pace.h"

#include <algorithm>

#include "core/geometry/angles.h"

namespace ulf::coverage {
namespace {

// Guessed; docs/capture.md#guidance has the results with simulated people.
constexpr double kPaceLeast_s = 8;        // shortest time of work to measure over,
constexpr double kPaceLeastViews = 4;     // and smallest area, in views
constexpr double kPaceRest_s = 5;         // a longer time without a sign of work is a pause
constexpr double kPaceOver_s = 60;        // of work, over which the pace is measured,
constexpr double kPaceNothingFor_s = 20;  // of work that paints less than a view: the pace is unknown

}  // namespace

void CapturePace::Update(double time_s, double covered_sr, std::size_t views,
                         const std::optional<Eigen::Vector3d>& direction, double disc_radius) {
  if (!begun_) {
    begun_ = true;
    known_sr_ = covered_sr, known_views_ = views;
    sign_s_ = time_s, sign_at_ = direction;
    before_.push_back(now_);
    return;
  }
  // Corrected poses cover and open areas as well: only what new views paint is work.
  const double painted_sr = views > known_views_ ? std::max(0.0, covered_sr - known_sr_) : 0;
  known_sr_ = covered_sr, known_views_ = views;
  const bool moved = direction && (!sign_at_ || AngleBetween(*direction, *sign_at_) > disc_radius);
  if (painted_sr <= 0 && !moved) return;
  const double took_s = time_s - sign_s_;
  if (took_s > 0 && took_s <= kPaceRest_s) now_.work_s += took_s;
  now_.painted_sr += painted_sr;
  sign_s_ = time_s;
  if (direction) sign_at_ = direction;
  before_.push_back(now_);
  while (before_.size() > 2 && before_[1].work_s <= now_.work_s - kPaceOver_s) before_.pop_front();
}

std::optional<double> CapturePace::SecondsFor(double open_sr, double sr_per_view) const {
  if (before_.empty()) return std::nullopt;
  const double seconds = now_.work_s - before_.front().work_s;
  const double painted_sr = now_.painted_sr - before_.front().painted_sr;
  if (seconds < kPaceLeast_s || painted_sr < kPaceLeastViews * sr_per_view) return std::nullopt;
  const auto lately = std::ranges::find_if(
      before_, [&](const Worked& worked) { return worked.work_s >= now_.work_s - kPaceNothingFor_s; });
  const bool for_long = lately != before_.begin();
  if (for_long && now_.painted_sr - std::prev(lately)->painted_sr < sr_per_view) return std::nullopt;
  return std::max(0.0, open_sr) * seconds / painted_sr;
}

}  // namespace ulf::coverage
