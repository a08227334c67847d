// The error that is measured at frames against the error that is there, on all simulated scenes.
#include <algorithm>
#include <cmath>
#include <map>

#include "acquisition/simulator/scene/scene.h"
#include "tests/charts/makers.h"
#include "tests/charts/measured/measured_views.h"
#include "tests/support/floors.h"

namespace ulf::test {
namespace {

struct Pairs {
  std::vector<double> measured, truth;

  void Add(double measured_value, double true_value) {
    measured.push_back(measured_value);
    truth.push_back(true_value);
  }
  static double Mean(const std::vector<double>& values) {
    double sum = 0;
    for (const double value : values) sum += value;
    return sum / static_cast<double>(values.size());
  }
  double Correlation() const {
    const double mean_measured = Mean(measured), mean_truth = Mean(truth);
    double both = 0, of_measured = 0, of_truth = 0;
    for (std::size_t i = 0; i < measured.size(); ++i) {
      const double a = measured[i] - mean_measured, b = truth[i] - mean_truth;
      both += a * b;
      of_measured += a * a;
      of_truth += b * b;
    }
    return both / std::sqrt(of_measured * of_truth);
  }
  double Bias() const { return Mean(measured) - Mean(truth); }
};

}  // namespace

Chart MeasuredErrorChart(const ChartEffort& effort) {
  ChartPanel small{"at the size that is measured, on the subject's disc",
                   {"true [dB]"},
                   {"measured [dB]", false, true},
                   {},
                   false,
                   false};
  ChartPanel full{"against the renderer's picture at full size",
                  {"true [dB]"},
                  {"measured [dB]", false, true},
                  {},
                  false,
                  false};
  ChartPanel off{"displacement", {"true [px]"}, {"measured [px]"}, {}, false, false};
  small.diagonal = off.diagonal = true;
  Pairs db_small, db_full, px;
  std::vector<double> ms;
  for (const std::string& scene :
       effort.Of(std::vector<std::string>{"studio", "glass"}, acquisition::Scene::Names()))
    for (const double spacing : effort.Of(std::vector{10.0}, {6.0, 12.0}))
      for (const std::uint64_t seed : effort.Of(std::vector<std::uint64_t>{2}, {2, 3})) {
        const MeasuredScene measured = MeasureFrames(
            {.scene = scene, .seed = seed, .view_spacing = Radians(spacing), .frames = effort.Of(4, 16)});
        std::vector<double> of_measured, of_small, of_full, px_measured, px_true;
        for (const FrameMeasurement& frame : measured.frames) {
          of_measured.push_back(frame.measured.inside.db);
          of_small.push_back(frame.true_small_db);
          of_full.push_back(frame.true_db);
          px_measured.push_back(frame.measured.inside.misregistration_px);
          px_true.push_back(frame.true_px);
          db_small.Add(of_measured.back(), of_small.back());
          db_full.Add(of_measured.back(), of_full.back());
          px.Add(px_measured.back(), px_true.back());
          ms.push_back(frame.measure_ms);
        }
        const std::string name = fmt::format("{:g}", spacing);
        small.points.push_back({scene, name, Spread::Of(of_small), Spread::Of(of_measured)});
        full.points.push_back({scene, name, Spread::Of(of_full), Spread::Of(of_measured)});
        off.points.push_back({scene, name, Spread::Of(px_true), Spread::Of(px_measured)});
      }
  Chart chart;
  chart.title = "Measured errors: what frames say of the light field, against what is true";
  chart.about = fmt::format(
      "All scenes of the simulator, views 6 and 12 degrees apart (the number beside a row), seeds 2 and 3 "
      "(seed 1 was "
      "looked at while this was made); frames with the sensor's noise, poses of views and frames off by 0.3 "
      "pixels, "
      "geometry from those views. A row: median, lowest and highest of 16 frames. Over all {} frames: dB at "
      "the same "
      "size correlate by {:.2f}, bias {:+.1f} dB; against full size {:.2f}, {:+.1f} dB; displacements "
      "{:.2f}, {:+.2f} "
      "px. {:.0f} ms of processor a frame.",
      ms.size(), db_small.Correlation(), db_small.Bias(), db_full.Correlation(), db_full.Bias(),
      px.Correlation(), px.Bias(), Spread::Of(ms).median);
  chart.panels = {small, full, off};
  return chart;
}

}  // namespace ulf::test
