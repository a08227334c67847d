// Long captures, and what they take of memory, time and disk as they grow: two thousand views one after the
// other, and an hour as people use it.
#include <cstdlib>
#include <sstream>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "tests/measure/runner.h"
#include "tests/measure/table.h"
#include "tests/support/growth/capture_growth.h"
#include "tests/support/test_paths.h"

namespace ulf::test {
namespace {

std::vector<ChartPanel> GrowthPanels(const std::vector<GrowthRow>& rows) {
  const ChartAxis megabytes{.label = "[MB]", .from_zero = true},
      milliseconds{.label = "[ms]", .from_zero = true};
  Table table;
  table.Panel("memory", {"views"}, megabytes, {.compared = false});
  table.Panel("time for a frame", {"views"}, milliseconds, {.compared = false});
  table.Panel("on disk", {"views"}, megabytes, {.compared = false});
  for (const GrowthRow& row : rows) {
    const auto views = static_cast<double>(row.recorded);
    table.Add("memory", "resident", "", views, row.resident_mb);
    table.Add("memory", "in use", "", views, row.used_mb);
    table.Add("time for a frame", "by the clock", "", views, row.frame_ms);
    table.Add("time for a frame", "of the processor", "", views, row.processor_ms);
    table.Add("on disk", "light field", "", views, row.files_mb + row.journal_mb);
    table.Add("on disk", "journal", "", views, row.journal_mb);
  }
  return table.panels();
}

// What a run of use_test printed: in the file that ULF_USE_ROWS names, or a run of its own, of an hour.
std::string PrintedByUse(const Effort& effort) {
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

Chart MeasureLongCapture(const Effort& effort) {
  const ScratchFolder scratch;
  const LongCapture captured = CaptureManyViews(scratch / "lf", effort.Of(200, 2000), 20);
  if (const std::string grows = WhatGrows(captured.rows, {.mb_a_view = 0.015, .mb = 10});
      !grows.empty() && !effort.quick)
    throw Error("the capture grows as it must not: {}; see which commit did it", grows);
  return {
      .found = fmt::format("{} views of {}x{} in {:.1f} minutes; {} pauses for the disk, {} views lost.",
                           captured.summary.recorded, captured.camera.width, captured.camera.height,
                           captured.rows.back().minutes, captured.summary.pauses, captured.summary.unwritten),
      .panels = GrowthPanels(captured.rows)};
}

CHART(long_capture, MeasureLongCapture, "A capture of 2,000 views, one after the other", R"(A textured
  plane, as fast as its views are taken; poses known, every frame becomes a view; no tracking, no geometry,
  no display. Medians of a twentieth of the capture, from the arrival of a frame to the decision, without
  drawing the plane.)");

Chart MeasureCaptureInUse(const Effort& effort) {
  std::vector<GrowthRow> rows;
  std::istringstream lines(PrintedByUse(effort));
  for (std::string line; std::getline(lines, line);)
    if (const auto row = GrowthRowOf(line)) rows.push_back(*row);
  if (rows.empty()) throw Error("there is no row of a capture in what use_test printed");
  const GrowthRow& last = rows.back();
  return {.found = fmt::format("{:.0f} minutes, {} frames, {} views, {} with those that were taken back.",
                               last.minutes, last.frames, last.views, last.recorded),
          .panels = GrowthPanels(rows)};
}

CHART(capture_in_use, MeasureCaptureInUse, "A capture in use", R"(The simulated studio at 640x480, at the
  pace of a live camera, with tracking, geometry, the display, and somebody who presses a key every second,
  in software OpenGL. Medians of a minute; memory is the least of it.)",
      true);

}  // namespace
}  // namespace ulf::test
