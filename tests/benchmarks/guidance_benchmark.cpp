// Views and seconds to full coverage, with guidance and without, in captures without pictures: many seeds of
// the simulated operator, several sizes of subject, against the least number of views that the hexagonal
// lattice allows.
#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <iostream>

#include "tests/support/floors.h"
#include "tests/support/imagined_capture.h"

namespace ulf {
namespace {

struct Spread {
  double low = 0, median = 0, high = 0;
};

Spread SpreadOf(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return {values.front(), values[values.size() / 2], values.back()};
}

std::string InWords(const Spread& spread) {
  return fmt::format("{:.0f} ({:.0f}-{:.0f})", spread.median, spread.low, spread.high);
}

int RunBenchmark(const std::vector<std::string>& people, const std::vector<double>& thresholds,
                 const std::vector<double>& sizes, std::uint64_t first_seed, std::uint64_t seeds,
                 double until, bool each, const std::string& cap_text) {
  fmt::print(
      "| px | subject | who | full | views | of the least | seconds | way in degrees | lost % | guidance ms "
      "|\n");
  fmt::print("| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |\n");
  const Cap cap = Cap::ParseDegrees(cap_text);
  for (const double threshold_px : thresholds)
    for (const double size : sizes)
      for (const std::string& who : people) {
        std::vector<double> views, ratios, seconds, ways, lost;
        std::size_t full = 0;
        double ms_median = 0, ms_most = 0;
        for (std::uint64_t seed = first_seed; seed < first_seed + seeds; ++seed) {
          test::ImaginedCapture capture;
          capture.person = OperatorOptions::Parse(fmt::format("{}:{}", who, seed));
          capture.threshold_px = threshold_px;
          capture.subject_size = size;
          capture.until_share = until;
          capture.cap = cap;
          const test::ImaginedResult result = test::RunImagined(capture);
          views.push_back(static_cast<double>(result.views));
          ratios.push_back(static_cast<double>(result.views) / (until * result.LeastViews(cap)));
          seconds.push_back(result.seconds);
          ways.push_back(result.way * 180 / M_PI);
          lost.push_back(100 * result.lost_share);
          full += result.covered >= until;
          ms_median = std::max(ms_median, result.ms_guidance_median);
          ms_most = std::max(ms_most, result.ms_guidance_most);
          if (each)
            fmt::print("  {} seed {}: {} views, {:.0f} s, {:.1f} %, way {:.0f}, lost {:.1f} %\n", who, seed,
                       result.views, result.seconds, 100 * result.covered, result.way * 180 / M_PI,
                       100 * result.lost_share);
        }
        fmt::print("| {:g} | {:g} | {} | {}/{} | {} | {:.2f} | {} | {} | {:.1f} | {:.2f}, at most {:.1f} |\n",
                   threshold_px, size, who, full, seeds, InWords(SpreadOf(views)), SpreadOf(ratios).median,
                   InWords(SpreadOf(seconds)), InWords(SpreadOf(ways)), SpreadOf(lost).median, ms_median,
                   ms_most);
        std::fflush(stdout);
      }
  return 0;
}

}  // namespace
}  // namespace ulf

int main(int argc, char** argv) {
  CLI::App app("Captures by simulated operators, without pictures");
  std::vector<std::string> people{"guided", "unguided", "novice", "unguided-novice"};
  std::vector<double> thresholds{7, 12}, sizes{0.28};
  std::uint64_t first_seed = 1, seeds = 5;
  double until = 0.95;
  bool each = false;
  std::string cap = "60x40";
  app.add_option("--who", people)->delimiter(',');
  app.add_option("--threshold-px", thresholds)->delimiter(',');
  app.add_option("--subject-size", sizes)->delimiter(',');
  app.add_option("--first-seed", first_seed);
  app.add_option("--seeds", seeds);
  app.add_option("--until", until);
  app.add_option("--cap", cap);
  app.add_flag("--each", each);
  CLI11_PARSE(app, argc, argv);
  return ulf::RunBenchmark(people, thresholds, sizes, first_seed, seeds, until, each, cap);
}
