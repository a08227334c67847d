// How wrong the merged light of exposure brackets is, by how bright a pixel is, against the number of exposures: captured
// by the program from a hand that does not stand still, with the poses that it tracks and the geometry that it makes.
#include <cmath>
#include <map>

#include "acquisition/simulator/simulated_camera.h"
#include "core/base/error.h"
#include "core/light_field/light_field_io.h"
#include "render/stereo/bracket_merge.h"
#include "tests/charts/makers.h"
#include "tests/support/child_process.h"
#include "tests/support/floors.h"
#include "tests/support/test_paths.h"

namespace ulf::test {
namespace {

namespace fs = std::filesystem;

std::string UriOf(unsigned seed) {
  return fmt::format(
      "sim:lightbox?seed={}&width=480&height=360&format=bayerrg12&exposure_us=1000&fps=60&speed_deg_s=4&look_"
      "away=0",
      seed);
}

void CaptureBracket(unsigned seed, int exposures, double seconds, const fs::path& dir) {
  std::vector<std::string> command{ULF_BINARY,
                                   "capture",
                                   UriOf(seed),
                                   "-o",
                                   dir.string(),
                                   "--headless",
                                   "--deterministic",
                                   "--quality",
                                   "fast",
                                   "--max-seconds",
                                   fmt::format("{:g}", seconds)};
  if (exposures > 1) command.insert(command.end(), {"--bracket", fmt::format("{}x2EV", exposures)});
  ChildProcess capture(command);
  if (capture.Wait(1200) != 0) throw Error("{} failed", command[1]);
}

// By whole stops of the true light, in shares of the view's own full scale.
using ByStop = std::map<int, std::vector<double>>;

void AddErrors(const cv::Mat& light, const cv::Mat& truth, ByStop& errors) {
  for (int y = 0; y < light.rows; ++y)
    for (int x = 0; x < light.cols; ++x) {
      const double is = light.at<cv::Vec3f>(y, x)[1], should = truth.at<cv::Vec3f>(y, x)[1];
      if (!(should > 0)) continue;
      errors[static_cast<int>(std::floor(std::log2(should)))].push_back(std::abs(is / should - 1));
    }
}

struct Outcome {
  ByStop errors;
  std::vector<double> ghosts;
};

Outcome Measure(const fs::path& dir, const SimulatedCamera& camera, int pictures, bool align) {
  const LightField light_field = ReadLightField(dir);
  const auto proxy = ProxyForBrackets(light_field);
  Outcome outcome;
  const auto count = static_cast<int>(light_field.views.size());
  for (int i = 0; i < std::min(pictures, count); ++i) {
    const View& view =
        light_field.views[static_cast<std::size_t>((2 * i + 1) * count / (2 * std::min(pictures, count)))];
    const MergedView merged = MergeExposuresOf(light_field, view, *proxy, {.align = align});
    AddErrors(merged.merged.light, camera.CleanLinear(camera.hand().CamFromWorld(view.device_time_s)),
              outcome.errors);
    outcome.ghosts.push_back(100 * merged.merged.ghost_share);
  }
  return outcome;
}

}  // namespace

Chart BracketsChart(const ChartEffort& effort) {
  Chart chart;
  chart.title = "Exposure brackets: the merged light against the light that is there";
  chart.about = fmt::format(
      "Simulated scene lightbox (sixteen stops), 12-bit mosaic with noise, captured by a hand that moves at "
      "4 degrees a "
      "second at 60 frames a second: ulf capture --bracket Nx2EV, its tracked poses and its mesh. Green of "
      "{} views of each "
      "of the seeds 1 to {}, by the whole stop of the true light (0: full scale of the view's own exposure). "
      "Bars: lowest to "
      "highest seed. Ringed: what is done.",
      effort.Of(2, 6), effort.Of(1, 3));
  const auto by_light = [](const char* title) {
    return ChartPanel{title,
                      {"light, stops over full scale of the view's own exposure"},
                      {"error, share of the light (median)", true},
                      {},
                      false};
  };
  ChartPanel aligned = by_light("aligned by poses and geometry"), lying = by_light("as they lie"),
             ghosts{
                 "ghosts", {"exposures"}, {"ghosts [% of the pixels]", false, false, false, true}, {}, false};
  for (const int exposures : effort.Of(std::vector{1, 3}, {1, 3, 5, 7})) {
    std::map<bool, std::map<int, std::vector<double>>> medians;
    std::map<bool, std::vector<double>> shares;
    for (unsigned seed = 1; seed <= effort.Of(1u, 3u); ++seed) {
      const ScratchFolder scratch;
      CaptureBracket(seed, exposures, effort.Of(6, 14), scratch / "lf");
      const SimulatedCamera camera(SimulationOptions::FromUri(DeviceUri::Parse(UriOf(seed))));
      for (const bool align : {true, false}) {
        if (exposures == 1 && !align) continue;
        const Outcome outcome = Measure(scratch / "lf", camera, effort.Of(2, 6), align);
        constexpr std::size_t kFew = 200;  // pixels
        for (const auto& [stop, errors] : outcome.errors)
          if (errors.size() >= kFew) medians[align][stop].push_back(ChartSpread::Of(errors).median);
        shares[align].push_back(ChartSpread::Of(outcome.ghosts).median);
      }
    }
    const std::string name = exposures == 1 ? "1 exposure" : fmt::format("{} exposures", exposures);
    for (const auto& [align, by_stop] : medians)
      for (const auto& [stop, values] : by_stop)
        (align ? aligned : lying)
            .points.push_back({name, "", Spread::Exactly(stop + 0.5), Spread::Of(values), false});
    for (const auto& [align, values] : shares)
      if (exposures > 1)
        ghosts.points.push_back({align ? "aligned" : "as they lie", fmt::format("{}", exposures),
                                 Spread::Exactly(exposures), Spread::Of(values), align});
  }
  chart.panels = {aligned, lying, ghosts};
  return chart;
}

}  // namespace ulf::test
