#include "coverage/bound/gap_words.h"

#include <fmt/format.h>

#include <cmath>

#include "core/base/counted.h"
#include "core/geometry/angles.h"

namespace ulf::coverage {
namespace {

// Returns the half of the cap that a gap's middle is in, by the side to which it is farther out.
const char* HalfOf(const CapGap& gap, const Cap& cap) {
  constexpr double kOff = 0.1;  // of half the cap; less is the middle. Guessed.
  const double right = 2 * gap.azimuth_deg / Degrees(cap.width);
  const double up = 2 * gap.elevation_deg / Degrees(cap.height);
  if (std::max(std::abs(right), std::abs(up)) < kOff) return "in the middle";
  if (std::abs(right) >= std::abs(up)) return right > 0 ? "right half" : "left half";
  return up > 0 ? "upper half" : "lower half";
}

}  // namespace

std::vector<CapGap> GapsOf(const CoverageMap& map) {
  std::vector<CapGap> gaps;
  if (!map.frame()) return gaps;
  for (const CoverageHole& hole : map.Holes()) {
    const CapFrame::Angles at = map.frame()->Of(hole.direction);
    gaps.push_back(
        {hole.solid_angle_sr * Degrees(1) * Degrees(1), Degrees(at.azimuth), Degrees(at.elevation)});
  }
  return gaps;
}

std::string PlaceInWords(const CapGap& gap, const char* degree) {
  const auto part = [&](double degrees, const char* positive, const char* negative) {
    const double rounded = std::round(std::abs(degrees));
    return rounded < 1 ? std::string()
                       : fmt::format("{:.0f}{} {}", rounded, degree, degrees > 0 ? positive : negative);
  };
  const std::string right = part(gap.azimuth_deg, "right", "left"),
                    up = part(gap.elevation_deg, "up", "down");
  if (right.empty() && up.empty()) return "at the first view";
  return right + (right.empty() || up.empty() ? "" : " and ") + up + " of the first view";
}

std::string InWords(const std::vector<CapGap>& gaps, const Cap& cap, const char* degree) {
  // Guessed: from where on a gap is large, and lies on no side; and from where on it is all that matters of
  // what is open.
  constexpr double kLarge = 0.1, kMost = 0.6, kNearlyAll = 0.9, kWhole = 0.995;
  if (gaps.empty()) return {};
  double open_deg2 = 0;
  for (const CapGap& gap : gaps) open_deg2 += gap.area_deg2;
  const double cap_deg2 = cap.SolidAngle() * Degrees(1) * Degrees(1);
  const std::string place = gaps[0].area_deg2 > kWhole * cap_deg2 ? "the whole cap"
                            : gaps[0].area_deg2 > kMost * cap_deg2
                                ? "most of the cap"
                                : fmt::format("{}, {}", HalfOf(gaps[0], cap), PlaceInWords(gaps[0], degree));
  const bool is_large = gaps[0].area_deg2 >= kLarge * cap_deg2;
  const std::size_t others = gaps.size() - 1;
  if (others == 0 || (is_large && gaps[0].area_deg2 >= kNearlyAll * open_deg2))
    return fmt::format("one {} gap: {}{}", is_large ? "large" : "small", place,
                       others == 0 ? "" : "; and " + Counted(others, "small one"));
  return fmt::format("{}, {:.2g} % of the cap in all; the largest: {}", Counted(gaps.size(), "gap"),
                     100 * open_deg2 / cap_deg2, place);
}

}  // namespace ulf::coverage
