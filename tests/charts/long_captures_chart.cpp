// Long captures, and what they take of memory, time and disk as they grow: two thousand views one after the
// other, and an hour as people use it.
#include <cstdlib>
#include <sstream>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "tests/charts/makers.h"
#include "tests/support/growth/capture_growth.h"
#include "tests/support/test_paths.h"

namespace ulf::test {
namespace {

std::vector<ChartPanel> GrowthPanels(const std::vector<GrowthRow>& rows) {
  ChartPanel memory{"memory", {"views"}, {"[MB]", false, false, false, true}, {}, false};
  ChartPanel time{"time for a frame", {"views"}, {"[ms]", false, false, false, true}, {}, false};
  ChartPanel disk{"on disk", {"views"}, {"[MB]", false, false, false, true}, {}, false};
  for (const GrowthRow& row : rows) {
    const Spread at = Spread::Exactly(static_cast<double>(row.recorded));
    memory.points.push_back({"resident", "", at, Spread::Exactly(row.resident_mb)});
    memory.points.push_back({"in use", "", at, Spread::Exactly(row.used_mb)});
    time.points.push_back({"by the clock", "", at, Spread::Exactly(row.frame_ms)});
    time.points.push_back({"of the processor", "", at, Spread::Exactly(row.processor_ms)});
    disk.points.push_back({"light field", "", at, Spread::Exactly(row.files_mb + row.journal_mb)});
    disk.points.push_back({"journal", "", at, Spread::Exactly(row.journal_mb)});
  }
  return {memory, time, disk};
}

// What a run of use_test printed: in the file that ULF_USE_ROWS names, or a run of its own, of an hour.
std::string PrintedByUse(const ChartEffort& effort) {
  if (const char* rows = std::getenv("ULF_USE_ROWS")) return ReadWholeFile(rows);
  const ScratchFolder scratch;
  const std::string printed = (scratch / "printed").string();
  const std::string command = fmt::format(
      "ULF_USE_PACED=1 ULF_USE_MINUTES={} ULF_USE_FPS=5 ULF_USE_WIDTH=640 ULF_USE_ROW_DEG=1 "
      "ULF_USE_THRESHOLD=6 "
      "'" USE_TEST "' >'{}'",
      effort.Of(3, 60), printed);
  if (std::system(command.c_str()) != 0)
    throw Error("the capture failed, or grows as it must not; it printed\n{}", ReadWholeFile(printed));
  return ReadWholeFile(printed);
}

}  // namespace

Chart LongCaptureChart(const ChartEffort& effort) {
  const ScratchFolder scratch;
  const LongCapture captured = CaptureManyViews(scratch / "lf", effort.Of(200, 2000), 20);
  if (const std::string grows = WhatGrows(captured.rows, {.mb_a_view = 0.015, .mb = 10});
      !grows.empty() && !effort.quick)
    throw Error("the capture grows as it must not: {}; see which commit did it", grows);
  Chart chart;
  chart.title = fmt::format("A capture of {} views, one after the other", captured.summary.recorded);
  chart.about = fmt::format(
      "A textured plane at {}x{}, as fast as its views are taken ({:.1f} minutes); poses known, every frame "
      "becomes a view; no tracking, no geometry, no display. Medians of a twentieth of the capture, from the "
      "arrival of a frame to the decision, without drawing the plane. {} pauses for the disk, {} views lost.",
      captured.camera.width, captured.camera.height, captured.rows.back().minutes, captured.summary.pauses,
      captured.summary.unwritten);
  chart.panels = GrowthPanels(captured.rows);
  return chart;
}

Chart CaptureInUseChart(const ChartEffort& effort) {
  std::vector<GrowthRow> rows;
  std::istringstream lines(PrintedByUse(effort));
  for (std::string line; std::getline(lines, line);)
    if (const auto row = GrowthRowOf(line)) rows.push_back(*row);
  if (rows.empty()) throw Error("there is no row of a capture in what use_test printed");
  const GrowthRow& last = rows.back();
  Chart chart;
  chart.title = fmt::format("A capture of {:.0f} minutes in use", last.minutes);
  chart.about = fmt::format(
      "The simulated studio at 640x480, at the pace of a live camera, with tracking, geometry, the display, "
      "and "
      "somebody who presses a key every second, in software OpenGL: {} frames, {} views, {} with those that "
      "were "
      "taken back. Medians of a minute; memory is the least of it.",
      last.frames, last.views, last.recorded);
  chart.panels = GrowthPanels(rows);
  return chart;
}

}  // namespace ulf::test
