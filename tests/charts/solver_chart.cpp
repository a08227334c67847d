// Minimal solvers and how many samples are drawn: time against what the pose is off by, OpenGV's solvers side
// by side in the product's sampler.
#include <algorithm>
#include <span>

#include "core/base/quantile.h"
#include "tests/charts/makers.h"
#include "tests/charts/solver_grid.h"

namespace ulf::test {
namespace {

constexpr int kInUse = 500;              // samples at most, in the product
constexpr double kTooLong_ms = 60;       // a solver that takes longer is not asked for more samples
constexpr double kLeastShown_pct = 0.1;  // on a logarithmic axis

std::vector<unsigned> Seeds(const ChartEffort& effort) {
  return effort.Of(std::vector{21u}, {21u, 22u, 23u});
}

// Over geometries and seeds: of each seed the median over the geometries.
struct Collected {
  std::vector<double> ms, rotation_deg, position, failures_pct;
};

template <typename Solver>
Collected Collect(std::span<const Geometry> geometries, const Solver& solver, Trials trials,
                  const ChartEffort& effort) {
  Collected collected;
  trials.count = effort.Of(2, 5);
  for (const unsigned seed : Seeds(effort)) {
    trials.seed = seed;
    std::vector<double> rotation, position;
    double ms = 0, failures = 0;
    for (const Geometry& geometry : geometries) {
      const Outcome outcome = RunTrials(geometry, solver, trials);
      ms += outcome.ms / static_cast<double>(geometries.size());
      failures += 100 * outcome.failures / static_cast<double>(geometries.size());
      rotation.push_back(outcome.rotation_deg);
      position.push_back(outcome.position);
    }
    collected.ms.push_back(ms);
    collected.rotation_deg.push_back(Median(rotation));
    collected.position.push_back(Median(position));
    collected.failures_pct.push_back(std::max(failures, kLeastShown_pct));
  }
  return collected;
}

template <typename NamedSolver>
ChartPanel AlonePanel(std::span<const Geometry> geometries, const std::vector<NamedSolver>& solvers,
                      const ChartEffort& effort) {
  ChartPanel panel{"the solver alone, single samples without noise, by geometry",
                   {"a call [µs, CPU]", true},
                   {"the truth is not among its solutions [%]", true},
                   {},
                   false,
                   false};
  for (const NamedSolver& solver : solvers)
    for (const Geometry& geometry : geometries) {
      std::vector<double> us, misses;
      for (const unsigned seed : Seeds(effort)) {
        const Alone alone = RunAlone(geometry, solver.solver, effort.Of(30, 200), seed);
        us.push_back(alone.us);
        misses.push_back(std::max(100 * alone.misses, kLeastShown_pct));
      }
      panel.points.push_back({solver.name, geometry.name, Spread::Of(us), Spread::Of(misses),
                              &solver == &solvers.front() && &geometry == &geometries.front()});
    }
  return panel;
}

template <typename NamedSolver>
ChartPanel FailuresPanel(std::span<const Geometry> geometries, const std::vector<NamedSolver>& solvers,
                         const ChartEffort& effort) {
  ChartPanel panel{fmt::format("0.5 px of noise, by the share of outliers, up to {} samples", kInUse),
                   {"a problem [ms, CPU]", true},
                   {"failed [%]", true},
                   {},
                   false};
  for (const NamedSolver& solver : solvers)
    for (const double outliers : {0.0, 0.5, 0.7}) {
      const Collected collected =
          Collect(geometries, solver.solver, {.noise_px = 0.5, .outliers = outliers}, effort);
      panel.points.push_back({solver.name, fmt::format("{:g} %", 100 * outliers), Spread::Of(collected.ms),
                              Spread::Of(collected.failures_pct), &solver == &solvers.front()});
      if (Median(collected.ms) > 4 * kTooLong_ms) break;
    }
  return panel;
}

// Rotation and position against time as more samples are allowed.
template <typename NamedSolver>
void AddSampling(Chart& chart, std::span<const Geometry> geometries, const std::vector<NamedSolver>& solvers,
                 const std::string& position_label, const ChartEffort& effort) {
  for (const double noise_px : {0.5, 2.0}) {
    const std::string title = fmt::format("half outliers, {:g} px of noise: samples drawn at most", noise_px);
    ChartPanel rotation{
        "rotation, " + title, {"a problem [ms, CPU]", true}, {"rotation is off by [degrees]", true}, {}};
    ChartPanel position{"position, " + title, {"a problem [ms, CPU]", true}, {position_label, true}, {}};
    for (const NamedSolver& solver : solvers)
      for (const int samples : effort.Of(std::vector{30, 500}, {10, 30, 100, 200, 500, 1000})) {
        const Collected collected =
            Collect(geometries, solver.solver,
                    {.noise_px = noise_px, .outliers = 0.5, .max_iterations = samples}, effort);
        const bool in_use = &solver == &solvers.front() && samples == kInUse;
        rotation.points.push_back({solver.name, std::to_string(samples), Spread::Of(collected.ms),
                                   Spread::Of(collected.rotation_deg), in_use});
        position.points.push_back({solver.name, std::to_string(samples), Spread::Of(collected.ms),
                                   Spread::Of(collected.position), in_use});
        if (Median(collected.ms) > kTooLong_ms) break;
      }
    chart.panels.push_back(rotation);
    chart.panels.push_back(position);
  }
}

template <typename NamedSolver>
Chart SolversChart(const std::string& title, std::span<const Geometry> geometries,
                   const std::vector<NamedSolver>& solvers, const std::string& refined,
                   const std::string& position_label, const ChartEffort& effort) {
  Chart chart;
  chart.title = title;
  chart.about =
      "OpenGV's solvers on drawn problems in the sampler of the product (which stops when it is sure); " +
      refined +
      " Three seeds of five problems for each geometry, other seeds than the tests', medians over "
      "geometries, found or not; bars: lowest to highest seed. 0.1 % is shown for all that is less.";
  chart.panels.push_back(AlonePanel(geometries, solvers, effort));
  chart.panels.push_back(FailuresPanel(geometries, solvers, effort));
  AddSampling(chart, geometries, solvers, position_label, effort);
  return chart;
}

}  // namespace

Chart OneCameraSolversChart(const ChartEffort& effort) {
  return SolversChart("One camera from points: solvers and samples", kAbsoluteGeometries, AbsoluteSolvers(),
                      "poses are refined on their inliers as in tracking.",
                      "the centre is off by [% of the nearest depth]", effort);
}

Chart TwoViewSolversChart(const ChartEffort& effort) {
  return SolversChart("Two views: solvers and samples", kRelativeGeometries, EssentialSolvers(),
                      "motions are left as a sample gave them.", "the direction is off by [degrees]", effort);
}

}  // namespace ulf::test
