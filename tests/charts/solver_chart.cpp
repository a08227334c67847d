// Minimal solvers and how many samples are drawn: time against what the pose is off by, OpenGV's solvers side
// by side in the product's sampler.
#include <fmt/format.h>

#include <algorithm>
#include <span>

#include "core/base/quantile.h"
#include "tests/charts/solver_grid.h"
#include "tests/measure/runner.h"
#include "tests/measure/table.h"

namespace ulf::test {
namespace {

constexpr int kInUse = 500;              // samples at most, in the product
constexpr double kTooLong_ms = 60;       // a solver that takes longer is not asked for more samples
constexpr double kLeastShown_pct = 0.1;  // on a logarithmic axis

// Of a seed, over its geometries: means, and medians of the errors.
template <typename Solver>
Outcome Overall(std::span<const Geometry> geometries, const Solver& solver, Trials trials, unsigned seed,
                const Effort& effort) {
  trials.count = effort.Of(2, 5);
  trials.seed = seed;
  Outcome overall;
  std::vector<double> rotation, position;
  for (const Geometry& geometry : geometries) {
    const Outcome outcome = RunTrials(geometry, solver, trials);
    overall.ms += outcome.ms / static_cast<double>(geometries.size());
    overall.failures += outcome.failures / static_cast<double>(geometries.size());
    rotation.push_back(outcome.rotation_deg);
    position.push_back(outcome.position);
  }
  overall.rotation_deg = Median(rotation);
  overall.position = Median(position);
  return overall;
}

double ShownPct(double share) { return std::max(100 * share, kLeastShown_pct); }

template <typename NamedSolver>
void AddAlone(std::span<const Geometry> geometries, const std::vector<NamedSolver>& solvers,
              const Effort& effort, Table& table) {
  const std::string title = "the solver alone, single samples without noise, by geometry";
  table.Panel(title, Log("a call [µs, CPU]"), Log("the truth is not among its solutions [%]"),
              {.compared = false, .joined = false});
  for (const NamedSolver& solver : solvers)
    for (const Geometry& geometry : geometries)
      for (const unsigned seed : effort.Seeds(3)) {
        const Alone alone = RunAlone(geometry, solver.solver, effort.Of(30, 200), seed);
        table.Add(title, solver.name, geometry.name, alone.us, ShownPct(alone.misses),
                  &solver == &solvers.front() && &geometry == &geometries.front());
      }
}

template <typename NamedSolver>
void AddFailures(std::span<const Geometry> geometries, const std::vector<NamedSolver>& solvers,
                 const Effort& effort, Table& table) {
  const std::string title =
      fmt::format("0.5 px of noise, by the share of outliers, up to {} samples", kInUse);
  table.Panel(title, Log("a problem [ms, CPU]"), Log("failed [%]"), {.compared = false});
  for (const NamedSolver& solver : solvers)
    for (const double outliers : {0.0, 0.5, 0.7}) {
      std::vector<double> ms;
      for (const unsigned seed : effort.Seeds(3)) {
        const Outcome of =
            Overall(geometries, solver.solver, {.noise_px = 0.5, .outliers = outliers}, seed, effort);
        table.Add(title, solver.name, fmt::format("{:g} %", 100 * outliers), of.ms, ShownPct(of.failures),
                  &solver == &solvers.front());
        ms.push_back(of.ms);
      }
      if (Median(ms) > 4 * kTooLong_ms) break;
    }
}

// Rotation and position against time as more samples are allowed.
template <typename NamedSolver>
void AddSampling(std::span<const Geometry> geometries, const std::vector<NamedSolver>& solvers,
                 const std::string& position_label, const Effort& effort, Table& table) {
  for (const double noise_px : {0.5, 2.0}) {
    const std::string title = fmt::format("half outliers, {:g} px of noise: samples drawn at most", noise_px);
    const std::string rotation = "rotation, " + title, position = "position, " + title;
    const ChartAxis cost{"a problem [ms, CPU]", true};
    table.Panel(rotation, cost, Log("rotation is off by [degrees]"));
    table.Panel(position, cost, Log(position_label));
    for (const NamedSolver& solver : solvers)
      for (const int samples : effort.Of(std::vector{30, 500}, {10, 30, 100, 200, 500, 1000})) {
        std::vector<double> ms;
        for (const unsigned seed : effort.Seeds(3)) {
          const Outcome of =
              Overall(geometries, solver.solver,
                      {.noise_px = noise_px, .outliers = 0.5, .max_iterations = samples}, seed, effort);
          const bool in_use = &solver == &solvers.front() && samples == kInUse;
          table.Add(rotation, solver.name, std::to_string(samples), of.ms, of.rotation_deg, in_use);
          table.Add(position, solver.name, std::to_string(samples), of.ms, of.position, in_use);
          ms.push_back(of.ms);
        }
        if (Median(ms) > kTooLong_ms) break;
      }
  }
}

template <typename NamedSolver>
Chart MeasureSolvers(std::span<const Geometry> geometries, const std::vector<NamedSolver>& solvers,
                     const std::string& position_label, const Effort& effort) {
  Table table;
  AddAlone(geometries, solvers, effort, table);
  AddFailures(geometries, solvers, effort, table);
  AddSampling(geometries, solvers, position_label, effort, table);
  return {.panels = table.panels()};
}

constexpr char kSolversAbout[] = R"( Three seeds of five problems for each geometry, medians over geometries,
  found or not; bars: lowest to highest seed. 0.1 % is shown for all that is less.)";

CHART(
    one_camera_solvers,
    [](const Effort& effort) {
      return MeasureSolvers(kAbsoluteGeometries, AbsoluteSolvers(),
                            "the centre is off by [% of the nearest depth]", effort);
    },
    "One camera from points: solvers and samples",
    std::string(R"(OpenGV's solvers on drawn problems in the
  sampler of the product (which stops when it is sure); poses are refined on their inliers as in tracking.)") +
        kSolversAbout);

CHART(
    two_view_solvers,
    [](const Effort& effort) {
      return MeasureSolvers(kRelativeGeometries, EssentialSolvers(), "the direction is off by [degrees]",
                            effort);
    },
    "Two views: solvers and samples",
    std::string(R"(OpenGV's solvers on drawn problems in the sampler of the product (which stops when it is
  sure); motions are left as a sample gave them.)") +
        kSolversAbout);

}  // namespace
}  // namespace ulf::test
