// What ./run charts draws. Each measures in this process (or asks the program ulf) and returns its rows.
#pragma once

#include <fmt/core.h>
#include <fstream>

#include "tests/charts/chart.h"

namespace ulf::test {

struct ChartEffort {
  bool quick = false;  // fewer seeds and values: whether it works, not what the pages show
  // The first of two numbers, or lists, for quick ones.
  template <typename T>
  T Of(T quickly, T fully) const {
    return quick ? quickly : fully;
  }
};

Chart BoundChart(const ChartEffort& effort);
Chart ThresholdChart(const ChartEffort& effort);
Chart BundleChart(const ChartEffort& effort);
Chart CalibrationChart(const ChartEffort& effort);
Chart OneCameraSolversChart(const ChartEffort& effort);
Chart TwoViewSolversChart(const ChartEffort& effort);
Chart ProxyChart(const ChartEffort& effort);
Chart GeometryChart(const ChartEffort& effort);
Chart RenderingChart(const ChartEffort& effort);
Chart ViewCountChart(const ChartEffort& effort);
Chart ViewerChart(const ChartEffort& effort);
Chart TrackingChart(const ChartEffort& effort);
Chart TrackingSideChart(const ChartEffort& effort);
Chart TrackingStepsChart(const ChartEffort& effort);
Chart LensChart(const ChartEffort& effort);
Chart MapSizeChart(const ChartEffort& effort);
Chart TrackingLevelsChart(const ChartEffort& effort);
Chart TrackingAdjustmentChart(const ChartEffort& effort);
Chart PredictedErrorChart(const ChartEffort& effort);
Chart WrongChoiceChart(const ChartEffort& effort);
Chart CoverChart(const ChartEffort& effort);
Chart MeasuredErrorChart(const ChartEffort& effort);
Chart LongCaptureChart(const ChartEffort& effort);
Chart CaptureInUseChart(const ChartEffort& effort);
Chart PacketsChart(const ChartEffort& effort);
Chart ClippedChart(const ChartEffort& effort);
Chart BracketsChart(const ChartEffort& effort);
Chart ColourChart(const ChartEffort& effort);

}  // namespace ulf::test
