// Views against the quality of pictures: recording by the bound, and by errors that are measured while capturing.
#include <unistd.h>

#include <filesystem>

#include "tests/charts/makers.h"
#include "tests/charts/measured/cover_runs.h"
#include "tests/support/floors.h"

namespace ulf::test {
namespace {

struct Way {
  const char* series;
  const char* name;
  std::vector<std::string> options;
  bool is_default = false;
};

}  // namespace

Chart CoverChart(const ChartEffort& effort) {
  const std::vector<Way> ways =
      effort.Of(std::vector<Way>{{"bound", "20 px", {"--threshold-px", "20"}},
                                 {"measured", "33 dB", {"--cover", "measured:33"}}},
                std::vector<Way>{{"bound", "12 px", {"--quality", "fast"}},
                                 {"bound", "20 px", {"--threshold-px", "20"}},
                                 {"measured", "33 dB", {"--cover", "measured:33"}},
                                 {"measured", "36 dB", {"--cover", "measured:36"}}});
  const std::vector<std::string> scenes =
      effort.Of(std::vector<std::string>{"studio"}, {"studio", "glass", "plant", "bust", "picture"});
  Chart chart;
  chart.title = "Views against quality: recorded by the bound, and by measured errors";
  chart.about = fmt::format(
      "A cap of 60 x 40 degrees, at most 150 s of the camera's time, poses known, seed {} (seed 3 was looked "
      "at while "
      "this was made); pictures from the light field's own mesh at 40 places between the views, against the "
      "simulator's, on the subject's disc: the middle of the places, from the worst tenth up.",
      effort.Of(3, 4));
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / fmt::format("ulf_cover_{}", getpid());
  for (const std::string& scene : scenes) {
    ChartPanel panel{scene, {"views", true}, {"disc [dB]", false, true}, {}, false, true};
    for (const Way& way : ways) {
      const CoverRun run = RunCover(ULF_BINARY,
                                    {.scene = scene,
                                     .seed = effort.Of<std::uint64_t>(3, 4),
                                     .person = {},
                                     .cover = way.options,
                                     .most_seconds = effort.Of(20.0, 150.0)},
                                    folder);
      panel.points.push_back({way.series,
                              way.name,
                              Spread::Exactly(run.views),
                              {run.median_db, run.worst_db, run.median_db},
                              way.is_default});
    }
    chart.panels.push_back(panel);
  }
  return chart;
}

}  // namespace ulf::test
