// Makes the charts of docs/measured/charts/, each as table, SVG and PNG.
//
//   charts FOLDER [--quick] [NAME...]   measures and draws; without names all but what takes an hour
//   charts FOLDER --draw [NAME...]      draws the tables in FOLDER anew
#include <fmt/core.h>
#include <sys/wait.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>

#include "core/base/error.h"
#include "tests/charts/makers.h"
#include "tests/support/floors.h"

namespace ulf::test {
namespace {

namespace fs = std::filesystem;

struct Maker {
  const char* name;
  Chart (*make)(const ChartEffort&);
  bool takes_an_hour = false;  // and is made only where it is named
};

constexpr Maker kMakers[] = {{"coverage_bound", BoundChart},
                             {"coverage_threshold", ThresholdChart},
                             {"bundle_adjustment", BundleChart},
                             {"calibration", CalibrationChart},
                             {"one_camera_solvers", OneCameraSolversChart},
                             {"two_view_solvers", TwoViewSolversChart},
                             {"proxies", ProxyChart},
                             {"geometry", GeometryChart},
                             {"rendering", RenderingChart},
                             {"view_count", ViewCountChart},
                             {"viewer", ViewerChart},
                             {"tracking", TrackingChart},
                             {"tracking_side", TrackingSideChart},
                             {"tracking_steps", TrackingStepsChart},
                             {"lens", LensChart},
                             {"map_size", MapSizeChart},
                             {"tracking_levels", TrackingLevelsChart},
                             {"tracking_adjustment", TrackingAdjustmentChart},
                             {"predicted_error", PredictedErrorChart},
                             {"wrong_choice", WrongChoiceChart},
                             {"measured_error", MeasuredErrorChart},
                             {"cover", CoverChart},
                             {"long_capture", LongCaptureChart},
                             {"capture_in_use", CaptureInUseChart, true},
                             {"packets", PacketsChart},
                             {"clipped", ClippedChart},
                             {"brackets", BracketsChart},
                             {"colour", ColourChart}};

struct Arguments {
  fs::path folder;
  bool quick = false, draw = false;
  std::vector<std::string> names;
};

void Make(const Maker& maker, const Arguments& arguments) {
  const fs::path table = arguments.folder / (std::string(maker.name) + ".csv");
  if (arguments.draw) {
    if (fs::exists(table)) DrawChart(arguments.folder, ReadChart(table));
    return;
  }
  const auto begin = std::chrono::steady_clock::now();
  Chart chart = maker.make({arguments.quick});
  chart.name = maker.name;
  chart.caption =
      ChartCaption(fmt::format("./run charts {}{}", arguments.quick ? "--quick " : "", maker.name));
  WriteChart(table, chart);
  DrawChart(arguments.folder, chart);
  fmt::print("{}: {:.0f} s\n", maker.name,
             std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
  std::fflush(stdout);
}

// In a process of its own: one chart's threads, memory and network are none of the next one's.
bool MakeApart(const Maker& maker, const Arguments& arguments) {
  std::fflush(nullptr);
  const pid_t child = fork();
  if (child == 0) {
    try {
      Make(maker, arguments);
      std::fflush(nullptr);
      _exit(0);
    } catch (const std::exception& error) {
      fmt::print(stderr, "charts: {}: {}\n", maker.name, error.what());
      _exit(1);
    }
  }
  int status = 0;
  return child > 0 && waitpid(child, &status, 0) == child && WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

}  // namespace
}  // namespace ulf::test

int main(int count, char** words) {
  using namespace ulf::test;
  Arguments arguments;
  std::vector<std::string> known, usual;
  for (const Maker& maker : kMakers) {
    known.emplace_back(maker.name);
    if (!maker.takes_an_hour) usual.emplace_back(maker.name);
  }
  CLI::App app("Makes the charts of docs/measured/charts/");
  app.add_option("folder", arguments.folder, "Where tables and pictures go")->required();
  app.add_option("names", arguments.names, "Which charts; without, all that take minutes")
      ->check(CLI::IsMember(known));
  app.add_flag("--quick", arguments.quick, "Fewer seeds and values");
  app.add_flag("--draw", arguments.draw, "Draws the tables in the folder anew");
  try {
    app.parse(count, words);
    if (arguments.names.empty()) arguments.names = arguments.draw ? known : usual;
    fs::create_directories(arguments.folder);
    bool all_made = true;
    for (const Maker& maker : kMakers)
      if (std::find(arguments.names.begin(), arguments.names.end(), maker.name) != arguments.names.end())
        all_made = MakeApart(maker, arguments) && all_made;
    return all_made ? 0 : 1;
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  } catch (const std::exception& error) {
    fmt::print(stderr, "charts: {}\n", error.what());
    return 1;
  }
}
