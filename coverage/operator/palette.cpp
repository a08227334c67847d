#include "coverage/operator/palette.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <tuple>
#include <type_traits>
#include <utility>

#include "coverage/bound/criterion.h"

namespace ulf::coverage {
namespace {

// Remembers the last window: computing it takes a dozen milliseconds, and it changes only with the median
// distance of the views.
std::optional<DistanceLimits> RememberedWindow(const CriterionSetup& setup) {
  const auto key = std::tuple(setup.focal_px, setup.distance, setup.radius, setup.threshold_px);
  thread_local std::optional<std::pair<std::remove_const_t<decltype(key)>, std::optional<DistanceLimits>>>
      last;
  if (!last || last->first != key) last.emplace(key, DistanceWindow(setup));
  return last->second;
}

}  // namespace

const Palette& Palette::Standard() {
  static const Palette palette{.same = {70, 190, 90},
                               .farther = {225, 60, 60},
                               .nearer = {50, 120, 230},
                               .reopened = {255, 60, 220},
                               .guide = {255, 225, 40},
                               .alarm = {255, 45, 45},
                               .camera = {235, 30, 40},
                               .error_small = {60, 170, 210},
                               .error_at_goal = {250, 215, 70},
                               .error_large = {210, 30, 60}};
  return palette;
}

const Palette& Palette::ForColourBlind() {
  static const Palette palette{.same = {240, 236, 215},
                               .farther = {200, 90, 0},
                               .nearer = {0, 80, 190},
                               .reopened = {20, 20, 20},
                               .guide = {255, 225, 40},
                               .alarm = {255, 45, 45},
                               .camera = {235, 30, 40},
                               .error_small = {0, 80, 190},
                               .error_at_goal = {240, 236, 215},
                               .error_large = {200, 90, 0}};
  return palette;
}

render::Rgba Palette::OfNearer(double nearer_by) const {
  return nearer_by < 0 ? render::Mix(same, farther, -nearer_by) : render::Mix(same, nearer, nearer_by);
}

render::Rgba Palette::OfError(double db_above_goal) const {
  const double share = std::clamp(db_above_goal / kErrorReach_db, -1.0, 1.0);
  return share < 0 ? render::Mix(error_at_goal, error_large, -share)
                   : render::Mix(error_at_goal, error_small, share);
}

DistanceColors::DistanceColors(const CoverageMap& map, double present_distance, const Palette& palette)
    : palette_(palette), present_distance_(present_distance), center_(map.subject().center_in_world) {
  const auto window = RememberedWindow({.focal_px = map.views().front().fx,
                                        .distance = map.reference_distance(),
                                        .radius = map.subject().radius,
                                        .threshold_px = map.options().threshold_px});
  // A side without a limit takes the limit of the other.
  if (window && window->near) nearest_ = *window->near;
  farthest_ = window && window->far ? *window->far : 1 / nearest_;
}

double DistanceColors::Nearer(double recorded_distance) const {
  const double ratio = present_distance_ / recorded_distance;
  return ratio < 1 ? -std::log(ratio) / std::log(nearest_) : std::log(ratio) / std::log(farthest_);
}

}  // namespace ulf::coverage
