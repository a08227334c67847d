// Views and seconds to full coverage, with guidance and without, in captures without pictures: many seeds of
// the simulated operator, several sizes of subject, against the least number of views that the hexagonal
// lattice allows.
#include <fmt/core.h>

#include <algorithm>
#include <cstdlib>

#include "core/base/quantile.h"
#include "tests/measure/provenance.h"
#include "tests/measure/runner.h"
#include "tests/support/floors.h"
#include "tests/support/imagined_capture.h"

namespace ulf {
namespace {

using test::Spread;

std::string InWords(const Spread& spread) {
  return fmt::format("{:.0f} ({:.0f}-{:.0f})", spread.median, spread.low, spread.high);
}

struct Question {
  std::vector<std::string> people{"guided", "unguided", "novice", "unguided-novice"};
  std::vector<double> thresholds{7, 12}, sizes{0.28};
  std::uint64_t first_seed = test::kFirstSeed, seeds = 5;
  double until = 0.95;
  bool each = false;
  std::string cap = "60x40";
};

// A row of the table.
std::string Captures(const Question& asked, double threshold_px, double size, const std::string& who) {
  const Cap cap = Cap::ParseDegrees(asked.cap);
  std::vector<double> views, ratios, seconds, ways, lost;
  std::size_t full = 0;
  double ms_median = 0, ms_most = 0;
  for (std::uint64_t seed = asked.first_seed; seed < asked.first_seed + asked.seeds; ++seed) {
    test::ImaginedCapture capture;
    capture.person = OperatorOptions::Parse(fmt::format("{}:{}", who, seed));
    capture.threshold_px = threshold_px;
    capture.subject_size = size;
    capture.until_share = asked.until;
    capture.cap = cap;
    const test::ImaginedResult result = test::RunImagined(capture);
    views.push_back(static_cast<double>(result.views));
    ratios.push_back(static_cast<double>(result.views) / (asked.until * result.LeastViews(cap)));
    seconds.push_back(result.seconds);
    ways.push_back(result.way * 180 / M_PI);
    lost.push_back(100 * result.lost_share);
    full += result.covered >= asked.until;
    ms_median = std::max(ms_median, result.ms_guidance_median);
    ms_most = std::max(ms_most, result.ms_guidance_most);
    if (asked.each)
      fmt::print("  {} seed {}: {} views, {:.0f} s, {:.1f} %, way {:.0f}, lost {:.1f} %\n", who, seed,
                 result.views, result.seconds, 100 * result.covered, ways.back(), lost.back());
  }
  return fmt::format(
      "| {:g} | {:g} | {} | {}/{} | {} | {:.2f} | {} | {} | {:.1f} | {:.2f}, at most {:.1f} |\n",
      threshold_px, size, who, full, asked.seeds, InWords(Spread::Of(views)), Median(ratios),
      InWords(Spread::Of(seconds)), InWords(Spread::Of(ways)), Median(lost), ms_median, ms_most);
}

int Run(const Question& asked) {
  const char* page = std::getenv("ULF_FIGURES");
  const std::string made_by = page ? test::Provenance("./run measure benchmarks/guidance_benchmark") : "";
  std::string table =
      "| px | subject | who | full | views | of the least | seconds | way in degrees | lost % | guidance ms "
      "|\n"
      "| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |\n";
  fmt::print("{}", table);
  for (const double threshold_px : asked.thresholds)
    for (const double size : asked.sizes)
      for (const std::string& who : asked.people) {
        const std::string row = Captures(asked, threshold_px, size, who);
        fmt::print("{}", row);
        table += row;
        std::fflush(stdout);
      }
  if (page)
    test::ReplacePart(page, "guidance_benchmark",
                      fmt::format("### `guidance_benchmark`\n\n{}\n\n{}", made_by, table));
  return 0;
}

}  // namespace
}  // namespace ulf

int main(int argc, char** argv) {  // NOLINT(bugprone-exception-escape): it ends the program
  CLI::App app("Captures by simulated operators, without pictures", "guidance_benchmark");
  ulf::Question asked;
  app.add_option("--who", asked.people)->delimiter(',');
  app.add_option("--threshold-px", asked.thresholds)->delimiter(',');
  app.add_option("--subject-size", asked.sizes)->delimiter(',');
  app.add_option("--first-seed", asked.first_seed);
  app.add_option("--seeds", asked.seeds);
  app.add_option("--until", asked.until);
  app.add_option("--cap", asked.cap);
  app.add_flag("--each", asked.each);
  return ulf::test::RunTool(app, argc, argv, [&] { return ulf::Run(asked); });
}
