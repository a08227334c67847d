// Charts the choice of OpenGV's solvers: time against error, failures by geometry and by share of outliers.
//   solver_choice FOLDER [absolute|relative]   writes solver_choice_{absolute,relative}.{csv,png} there;
//   takes minutes.
#include <fmt/core.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <span>
#include <vector>

#include "acquisition/error.h"
#include "acquisition/gnuplot.h"
#include "tests/charts/solver_grid.h"

namespace ulf::test {
namespace {

constexpr std::array kOutliers{0.0, 0.5, 0.7};
constexpr std::array kNoise_px{0.5, 2.0};
constexpr std::array kColors{"#1f63b4", "#d95f02", "#4d8c15", "#7a5195", "#c2185b"};

struct Cell {
  std::size_t solver, geometry;
  double noise_px, outliers;
  Outcome outcome;
};

struct Mean {
  double sum = 0;
  int count = 0;
  void Add(double value) {
    sum += value;
    ++count;
  }
  double Value() const { return count > 0 ? sum / count : 0; }
};

template <typename NamedSolver>
class Chart {
 public:
  // `key`: where the last panel is empty.
  Chart(std::string title, std::string error_unit, std::string key, std::vector<NamedSolver> solvers,
        std::span<const Geometry> geometries)
      : title_(std::move(title)),
        error_unit_(std::move(error_unit)),
        key_(std::move(key)),
        solvers_(std::move(solvers)),
        geometries_(geometries) {}

  void Measure() {
    for (std::size_t s = 0; s < solvers_.size(); ++s)
      for (std::size_t g = 0; g < geometries_.size(); ++g) {
        fmt::print(stderr, "{}, {}\n", solvers_[s].name, geometries_[g].name);
        alone_.push_back(RunAlone(geometries_[g], solvers_[s].solver, 300, 1));
        for (const double noise_px : kNoise_px)
          for (const double outliers : kOutliers)
            cells_.push_back({s, g, noise_px, outliers,
                              RunTrials(geometries_[g], solvers_[s].solver,
                                        {.noise_px = noise_px, .outliers = outliers, .count = 6})});
      }
  }

  void WriteCsv(const std::filesystem::path& path) const {
    std::ofstream file(path);
    file << "solver,sample,geometry,noise_px,outlier_share,mean_ms,median_error,failure_share,alone_us,"
            "alone_miss_share\n";
    for (const Cell& cell : cells_) {
      const Alone& alone = AloneOf(cell.solver, cell.geometry);
      file << fmt::format("\"{}\",{},{},{},{},{:.4g},{:.4g},{:.3g},{:.3g},{:.3g}\n",
                          solvers_[cell.solver].name, solvers_[cell.solver].solver.sample_size,
                          geometries_[cell.geometry].name, cell.noise_px, cell.outliers, cell.outcome.ms,
                          cell.outcome.median_error, cell.outcome.failures, alone.us, alone.misses);
    }
    if (!file.flush()) throw Error("{}: cannot be written", path.string());
  }

  void Draw(const std::string& path) const {
    std::string script = fmt::format(
        "set multiplot layout 2,2 title '{}' font ',14' margins 0.06,0.985,0.08,0.91 spacing 0.075,0.16\n"
        "set grid y lc rgb '#e4e4e4' lt 1\nset border 3 lc rgb '#808080'\nset xtics nomirror\n"
        "set ytics nomirror\n",
        title_);
    script += Bars("alone", "the solver alone, single samples without noise: truth not among its solutions",
                   [&](std::size_t s, std::size_t g) { return 100 * AloneOf(s, g).misses; });
    script += TimeAgainstError();
    script += Bars("failures", "in the sampler, all noise and outlier levels: failed",
                   [&](std::size_t s, std::size_t g) {
                     Mean mean;
                     for (const Cell& cell : cells_)
                       if (cell.solver == s && cell.geometry == g) mean.Add(100 * cell.outcome.failures);
                     return mean.Value();
                   });
    script += FailuresAgainstTime();
    DrawChart(path, 1400, 980, script + "unset multiplot\n");
  }

 private:
  const Alone& AloneOf(std::size_t solver, std::size_t geometry) const {
    return alone_[solver * geometries_.size() + geometry];
  }

  std::string NameWithCost(std::size_t s) const {
    Mean us;
    for (std::size_t g = 0; g < geometries_.size(); ++g) us.Add(AloneOf(s, g).us);
    return fmt::format("{}: {} points, {:.3g} µs", solvers_[s].name, solvers_[s].solver.sample_size,
                       us.Value());
  }

  template <typename Value>
  std::string Bars(const std::string& data, const std::string& title, Value&& value) const {
    std::string script = fmt::format("${} << EOD\n", data);
    for (std::size_t g = 0; g < geometries_.size(); ++g) {
      script += fmt::format("\"{}\"", geometries_[g].name);
      for (std::size_t s = 0; s < solvers_.size(); ++s) script += fmt::format(" {:.4g}", value(s, g));
      script += "\n";
    }
    script += fmt::format(
        "EOD\nset title '{}'\nunset logscale\nset style data histograms\nset style histogram clustered gap "
        "1.5\n"
        "set style fill solid 0.85 noborder\nset yrange [0:100]\nset xrange [-0.6:{}]\nset format y '%g %%'\n"
        "set format x '%s'\nset xtics font ',10'\nset xlabel ''\nset ylabel ''\nunset key\nplot ",
        title, static_cast<double>(geometries_.size()) - 0.4);
    for (std::size_t s = 0; s < solvers_.size(); ++s)
      script += fmt::format("{}${} using {}:xtic(1) lc rgb '{}' notitle", s > 0 ? ", " : "", data, s + 2,
                            kColors[s]);
    return script + "\nunset key\n";
  }

  // Of each geometry at half outliers and the lower noise.
  std::string TimeAgainstError() const {
    std::string script;
    for (std::size_t s = 0; s < solvers_.size(); ++s) {
      script += fmt::format("$cost{} << EOD\n", s);
      for (const Cell& cell : cells_)
        if (cell.solver == s && cell.outliers == 0.5 && cell.noise_px == kNoise_px[0] &&
            cell.outcome.failures < 1)
          script += fmt::format("{:.4g} {:.4g} \"{}\"\n", cell.outcome.ms, cell.outcome.median_error,
                                geometries_[cell.geometry].name);
      script += "NaN NaN \"\"\nEOD\n";
    }
    script += fmt::format(
        "set title 'half outliers, {} px noise: error against time, a dot for each geometry'\nset logscale "
        "xy\n"
        "set autoscale\nset format x '%g'\nset format y '%g'\nset xlabel 'ms a problem'\n"
        "set ylabel 'median error [{}]'\nplot ",
        kNoise_px[0], error_unit_);
    for (std::size_t s = 0; s < solvers_.size(); ++s)
      script += fmt::format("{0}$cost{1} using 1:2 with points pt 7 ps 1.2 lc rgb '{2}' notitle",
                            s > 0 ? ", " : "", s, kColors[s]);
    return script + "\n";
  }

  std::string FailuresAgainstTime() const {
    std::string script;
    for (std::size_t s = 0; s < solvers_.size(); ++s) {
      script += fmt::format("$outliers{} << EOD\n", s);
      for (const double outliers : kOutliers) {
        Mean ms, failures;
        for (const Cell& cell : cells_)
          if (cell.solver == s && cell.outliers == outliers) {
            ms.Add(cell.outcome.ms);
            failures.Add(100 * cell.outcome.failures);
          }
        script += fmt::format("{:.4g} {:.3g} {}\n", ms.Value(), failures.Value(), 0.8 + 1.6 * outliers);
      }
      script += "EOD\n";
    }
    script += fmt::format(
        "set title 'all geometries: failed trials against time, with 0, 50 and 70 % outliers (larger dots)'\n"
        "unset logscale\nset logscale x\nset autoscale\nset yrange [0:100]\nset xrange [*:*]\n"
        "set key {} reverse Left samplen 1.5\nset format x '%g'\nset format y '%g %%'\n"
        "set xlabel 'ms a problem'\nset ylabel ''\nplot ",
        key_);
    for (std::size_t s = 0; s < solvers_.size(); ++s)
      script += fmt::format(
          "{0}$outliers{1} using 1:2 with lines lw 2 lc rgb '{2}' notitle, "
          "$outliers{1} using 1:2:3 with points pt 7 ps variable lc rgb '{2}' title '{3}'",
          s > 0 ? ", " : "", s, kColors[s], NameWithCost(s));
    return script + "\n";
  }

  std::string title_, error_unit_, key_;
  std::vector<NamedSolver> solvers_;
  std::span<const Geometry> geometries_;
  std::vector<Cell> cells_;
  std::vector<Alone> alone_;  // by solver, then geometry
};

template <typename Chart>
void Make(Chart chart, const std::filesystem::path& folder, const std::string& name) {
  chart.Measure();
  chart.WriteCsv(folder / (name + ".csv"));
  chart.Draw((folder / (name + ".png")).string());
}

}  // namespace
}  // namespace ulf::test

int main(int count, char** arguments) {
  using namespace ulf::test;
  const std::string only = count == 3 ? arguments[2] : "";
  if (count < 2 || count > 3) {
    fmt::print(stderr, "usage: solver_choice FOLDER [absolute|relative]\n");
    return 2;
  }
  try {
    if (only != "relative")
      Make(Chart("One camera from points: OpenGV''s solvers in our sampler", "px", "top left",
                 AbsoluteSolvers(), kAbsoluteGeometries),
           arguments[1], "solver_choice_absolute");
    if (only != "absolute")
      Make(Chart("Two views: OpenGV''s solvers in our sampler", "degrees", "bottom right", EssentialSolvers(),
                 kRelativeGeometries),
           arguments[1], "solver_choice_relative");
  } catch (const std::exception& error) {
    fmt::print(stderr, "solver_choice: {}\n", error.what());
    return 1;
  }
}
