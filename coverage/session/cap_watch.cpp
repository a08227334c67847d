#include "coverage/session/cap_watch.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "core/base/at.h"
#include "core/base/error.h"
#include "core/geometry/angles.h"
#include "coverage/bound/gap_words.h"

namespace ulf::coverage {
namespace {

// Guessed.
constexpr double kCapWatchStep = Radians(2);  // round the subject; less is a hand's trembling and no movement
constexpr double kCapWatchWorthGaining = 0.002;  // of the cap; less is no gain, more starts the count anew
// The watch reports after a movement without a gain of so many times the cap's width and height, which finds
// every hole that can be reached, and at least so many radians. Less reports too early, more too late.
constexpr double kCapWatchWaysRound = 2;
constexpr double kCapWatchLeastWay = M_PI / 2;
constexpr double kCapWatchWholeTurn = 1.1 * 2 * M_PI;  // of a turntable

std::string LargestGapInWords(const CoverageMap& map) {
  const std::vector<CapGap> gaps = GapsOf(map);
  return gaps.empty() ? "" : ", mostly " + PlaceInWords(gaps[0]);
}

}  // namespace

// Sums over the map's cells choose the sizes for which a map of their own is painted; that map decides.
std::optional<Cap> LargestCovered(const CoverageMap& map, double share) {
  if (!map.frame()) return std::nullopt;
  constexpr int kSizes = 50;
  std::vector<double> painted(kSizes, 0), whole(kSizes, 0);  // by the smallest size that holds a cell
  map.ForEachCell([&](const CoverageMap::CellView& cell) {
    const CapFrame::Angles at = map.frame()->Of(cell.direction);
    const double size = std::max(2 * std::abs(at.azimuth) / map.extent().width,
                                 2 * std::abs(at.elevation) / map.extent().height);
    const std::size_t index = At(static_cast<int>(std::clamp(size * kSizes, 0.0, kSizes - 1.0)));
    whole[index] += cell.solid_angle_sr;
    if (cell.covering.index >= 0) painted[index] += cell.solid_angle_sr;
  });
  std::partial_sum(painted.begin(), painted.end(), painted.begin());
  std::partial_sum(whole.begin(), whole.end(), whole.begin());
  const Eigen::Vector2d asked_deg = map.extent().Degrees();
  for (int i = kSizes - 1; i >= 0; --i) {
    if (painted[At(i)] < share * whole[At(i)]) continue;
    const Eigen::Vector2d degrees = ((i + 1.0) / kSizes * asked_deg).array().floor();
    if (degrees.minCoeff() < 1) return std::nullopt;
    const Cap cap = Cap::FromDegrees(degrees);
    CoverageMapOptions options = map.options();
    options.cap = cap;
    if (CoverageMap(map.subject(), options, map.views()).CoveredShare() >= share) return cap;
  }
  return std::nullopt;
}

std::optional<std::string> CapWatch::Update(const CoverageMap& map, const Eigen::Vector3d& center_in_world,
                                            bool would_record) {
  if (!map.options().cap || map.views().empty()) return std::nullopt;
  const Eigen::Vector3d direction = (center_in_world - map.subject().center_in_world).normalized();
  const double covered = map.CoveredShare();
  // The share falls when views are taken back or the subject is placed anew.
  if (covered >= share_ || covered > most_covered_ + kCapWatchWorthGaining ||
      covered < most_covered_ - kCapWatchWorthGaining) {
    most_covered_ = covered;
    from_ = direction;
    moved_ = 0;
    reported_ = false;
    return std::nullopt;
  }
  if (!would_record) {
    from_ = direction;
    return std::nullopt;
  }
  const double step = from_ ? AngleBetween(*from_, direction) : 0;
  if (!from_ || step >= kCapWatchStep) {
    from_ = direction;
    moved_ += step;
  }
  const Cap& cap = *map.options().cap;
  const double most_way = turns_ ? kCapWatchWholeTurn
                                 : std::max(kCapWatchWaysRound * (cap.width + cap.height), kCapWatchLeastWay);
  if (reported_ || moved_ < most_way) return std::nullopt;
  reported_ = true;
  std::string smaller = "ask for a smaller cap";
  if (const std::optional<Cap> largest = LargestCovered(map, share_)) {
    const Eigen::Vector2d degrees = largest->Degrees();
    smaller = fmt::format("resume with {} {:.0f}x{:.0f}, which is covered to {:g} %",
                          Parameter("until_covered"), degrees.x(), degrees.y(), 100 * share_);
  }
  const double open = 1 - covered;
  const char* to_do = IsTaken(source_) ? "; "
                      : turns_         ? ": set the camera higher or lower. Or finish now, or "
                                       : ". Finish now, or ";
  return fmt::format(
      "no new coverage in {}; {:.{}f} % still open{}{}{}",
      turns_ ? "a whole turn of the table" : fmt::format("the last {:.0f}° of movement", Degrees(moved_)),
      100 * open, open < 0.1 ? 1 : 0, LargestGapInWords(map), to_do, smaller);
}

}  // namespace ulf::coverage
