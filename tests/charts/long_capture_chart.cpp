// A capture of two thousand views, one after the other: what it takes of memory, time and disk as it grows.
#include "core/base/error.h"
#include "tests/charts/makers.h"
#include "tests/support/growth/long_capture.h"
#include "tests/support/test_paths.h"

namespace ulf::test {

Chart LongCaptureChart(const ChartEffort& effort) {
  const ScratchFolder scratch;
  const LongCapture captured = CaptureManyViews(scratch / "lf", effort.Of(200, 2000), 20);
  ChartPanel memory{"memory", {"views"}, {"[MB]", false, false, false, true}, {}, false};
  ChartPanel time{"time for a frame", {"views"}, {"[ms]", false, false, false, true}, {}, false};
  ChartPanel disk{"on disk", {"views"}, {"[MB]", false, false, false, true}, {}, false};
  for (const GrowthRow& row : captured.rows) {
    const Spread at = Spread::Exactly(static_cast<double>(row.views));
    memory.points.push_back({"resident", "", at, Spread::Exactly(row.resident_mb)});
    memory.points.push_back({"in use", "", at, Spread::Exactly(row.used_mb)});
    time.points.push_back({"by the clock", "", at, Spread::Exactly(row.frame_ms)});
    time.points.push_back({"of the processor", "", at, Spread::Exactly(row.processor_ms)});
    disk.points.push_back({"light field", "", at, Spread::Exactly(row.files_mb + row.journal_mb)});
    disk.points.push_back({"journal", "", at, Spread::Exactly(row.journal_mb)});
  }
  if (const std::string grows = WhatGrows(captured.rows, {.mb_a_view = 0.015, .mb = 10});
      !grows.empty() && !effort.quick)
    throw Error("the capture grows as it must not: {}; see which commit did it", grows);
  Chart chart;
  chart.title = fmt::format("A capture of {} views, one after the other", captured.summary.recorded);
  chart.about = fmt::format(
      "A textured plane at {}x{}, as fast as its views are taken ({:.1f} minutes); poses known, every frame "
      "becomes a "
      "view; no tracking, no geometry, no display. Medians of a twentieth of the capture, from the arrival "
      "of a frame to "
      "the decision, without drawing the plane. {} pauses for the disk, {} views lost.",
      captured.camera.width, captured.camera.height, captured.rows.back().minutes, captured.summary.pauses,
      captured.summary.unwritten);
  chart.panels = {memory, time, disk};
  return chart;
}

}  // namespace ulf::test
