// What it takes to find the worst pixel: the coverage bound's time against how far it falls short of brute
// force. Falling short is what matters: a view would count as covered that is not.
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>

#include "core/base/host_time.h"
#include "core/base/quantile.h"
#include "coverage/bound/criterion.h"
#include "coverage/bound/epipolar_plane.h"
#include "tests/measure/runner.h"
#include "tests/measure/table.h"
#include "tests/support/bound_oracle.h"
#include "tests/support/floors.h"

namespace ulf::test {
namespace {

using Eigen::Vector3d;

struct Pairing {
  CriterionView recorded, candidate;
  Subject subject;
  double truth_px = 0;
};

struct Range {
  const char* title;
  double farthest;       // of the candidate's distance over the recorded one's, and one over it
  double largest_angle;  // degrees
};

CriterionView Camera(double focal_px) {
  CriterionView view;
  view.fx = view.fy = focal_px;
  view.width = view.height = 4000;
  view.cx = view.cy = 2000;
  return view;
}

std::vector<Pairing> Draw(const Range& range, int count, unsigned seed) {
  std::mt19937 random(seed);
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  std::vector<Pairing> pairings;
  while (static_cast<int>(pairings.size()) < count) {
    const CriterionView camera = Camera(uniform(300, 2000));
    const double reach = std::log(range.farthest), distance = std::exp(uniform(-reach, reach));
    const double angle = std::exp(uniform(std::log(0.1), std::log(range.largest_angle))) * M_PI / 180;
    const Vector3d direction(std::sin(angle), 0, -std::cos(angle));
    Pairing pairing{camera.AimedAt(Vector3d::Zero(), -Vector3d::UnitZ(), -Vector3d::UnitY()),
                    camera.AimedAt(Vector3d::Zero(), distance * direction, -Vector3d::UnitY()),
                    {Vector3d::Zero(), uniform(0.03, 0.45)}};
    pairing.truth_px = OracleBoundPx(pairing.recorded, pairing.candidate, pairing.subject);
    if (std::isfinite(pairing.truth_px)) pairings.push_back(pairing);
  }
  return pairings;
}

struct Measured {
  double microseconds = 0;  // a bound, CPU
  double short_by = 0;      // %, one pair in a hundred is off by more
};

constexpr double kNoLimit = std::numeric_limits<double>::infinity();

// How the worst pixel is found. What any but the last misses, a capture would take for covered.
using Search = double (*)(const EpipolarPlane& plane);
double CentralPixel(const EpipolarPlane& plane) {
  return plane.ErrorAt(std::clamp(0.0, plane.lowest_pixel(), plane.highest_pixel()));
}
double Guess(const EpipolarPlane& plane) {
  return std::max(CentralPixel(plane), plane.ErrorAt(plane.FirstGuess()));
}
double Parabolas(const EpipolarPlane& plane) {
  const double guess = plane.FirstGuess(), error = plane.ErrorAt(guess);
  return std::max({CentralPixel(plane), error, plane.Refined(guess, error, kNoLimit)});
}
double Scan(const EpipolarPlane& plane) { return std::max(CentralPixel(plane), plane.Scanned(kNoLimit)); }

// `search`: null for the bound as a capture asks for it.
double BoundBy(Search search, const Pairing& pairing) {
  if (!search) return BoundPx(pairing.recorded, pairing.candidate, pairing.subject);
  const EpipolarPlane plane(pairing.recorded, pairing.candidate, pairing.subject,
                            AcrossAxis(pairing.recorded, pairing.candidate, pairing.subject));
  return plane.usable() ? search(plane) : kNoLimit;
}

Measured Measure(const std::vector<Pairing>& pairings, Search search, int repetitions) {
  std::vector<double> short_by;
  for (const Pairing& pairing : pairings) {
    short_by.push_back(100 * std::max(0.0, 1 - BoundBy(search, pairing) / pairing.truth_px));
  }
  double sum = 0;
  const double start = ThreadCpuSeconds();
  for (int i = 0; i < repetitions; ++i)
    for (const Pairing& pairing : pairings) sum += BoundBy(search, pairing);
  const double seconds = ThreadCpuSeconds() - start + 0 * sum;
  constexpr double kLeastShown = 0.01;  // %
  return {1e6 * seconds / static_cast<double>(repetitions * pairings.size()),
          std::max(kLeastShown, Quantile(short_by, 0.99))};
}

Chart MeasureBound(const Effort& effort) {
  constexpr std::array<std::pair<const char*, Search>, 5> kSearches{{{"central pixel (thesis)", CentralPixel},
                                                                     {"guess by closed form", Guess},
                                                                     {"guess and two parabolas", Parabolas},
                                                                     {"33 pixels and golden section", Scan},
                                                                     {"as needed", nullptr}}};
  Table table;
  for (const Range& range : {Range{"near the shell: distances 0.8 to 1.25, up to 10 degrees", 1.25, 10},
                             Range{"everywhere: distances 0.5 to 2, up to 60 degrees", 2, 60}}) {
    table.Panel(range.title, Log("time of a bound [µs, CPU]"),
                Log("short of brute force [%], 99th percentile"));
    for (const unsigned seed : effort.Seeds(5)) {
      const auto pairings = Draw(range, effort.Of(100, 500), seed);
      for (const auto& [name, search] : kSearches) {
        const Measured measured = Measure(pairings, search, effort.Of(20, 100));
        table.Add(range.title, name, name, measured.microseconds, measured.short_by, search == nullptr);
      }
    }
  }
  return {.panels = table.panels()};
}

CHART(coverage_bound, MeasureBound,
      "Coverage bound: what finding the worst pixel costs, and what is missed without", R"(Aimed pairs at
  random (focal length 300 to 2,000 px, sphere 0.03 to 0.45 of the distance), the truth by brute force over
  all pixels in space. Five seeds of 500 pairs; bars: lowest to highest seed. 0.01 % is shown for all that
  is less.)");

}  // namespace
}  // namespace ulf::test
