#include "render/quality/light_solution.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <utility>

#include "core/base/at.h"
#include "core/base/error.h"
#include "core/base/quantile.h"

namespace ulf::render {
namespace {

using Eigen::Vector2d;

double MiddleOf(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  if (values.size() % 2 == 1) return *middle;
  return 0.5 * (*middle + *std::max_element(values.begin(), middle));
}

// Returns the photograph's log light without the explained part.
double Corrected(const LightSolution& solution, int channel, const LightObservation& seen) {
  return seen.log_light - solution.log_gain[At(channel)][At(seen.view)] -
         std::log(FalloffOf(solution.falloff[At(seen.camera)], seen.r2));
}

// Solves by Gauss-Newton steps on weighted squares. A point's own light is eliminated: an observation's
// residual is its difference from the point's weighted mean.
class Normal {
 public:
  Normal(const std::vector<LightSample>& samples, int views, int cameras, LightModel model)
      : samples_(samples), views_(views), has_falloff_(model == LightModel::kGainsAndFalloff) {
    solution_.log_gain.fill(std::vector<double>(At(views), 0.0));
    solution_.falloff.assign(At(cameras), Vector2d::Zero());
    count_ = 3 * At(views) + 2 * At(cameras);
    for (const LightSample& sample : samples_)
      if (!sample.held_out) entries_ += sample.seen.size();
    weight_.resize(entries_);
    over_error_.resize(entries_);
  }

  const LightSolution& solution() const { return solution_; }

  // Computes residuals from the point's weighted mean, over the expected error; from the median at first.
  void Residuals(bool first) {
    std::size_t entry = 0;
    std::vector<double> values;
    for (const LightSample& sample : samples_) {
      if (sample.held_out) continue;
      values.clear();
      double sum = 0, total = 0;
      for (std::size_t i = 0; i < sample.seen.size(); ++i) {
        values.push_back(Corrected(solution_, sample.channel, sample.seen[i]));
        sum += weight_[entry + i] * values.back();
        total += weight_[entry + i];
      }
      std::vector<double> copy = values;
      const double center = first || total <= 0 ? MiddleOf(copy) : sum / total;
      for (std::size_t i = 0; i < values.size(); ++i)
        over_error_[entry + i] = (values[i] - center) / sample.seen[i].error;
      entry += sample.seen.size();
    }
  }

  double Scale() const {
    std::vector<double> sizes;
    sizes.reserve(entries_);
    for (const double value : over_error_) sizes.push_back(std::abs(value));
    return 1.4826 * Median(std::move(sizes));
  }

  // `weight` is a function of a residual over its expected error.
  template <typename Weight>
  void Reweigh(const Weight& weight) {
    std::size_t entry = 0;
    for (const LightSample& sample : samples_) {
      if (sample.held_out) continue;
      for (const LightObservation& seen : sample.seen) {
        const double sure = least_error / seen.error;
        weight_[entry] = weight(over_error_[entry]) * sure * sure;
        ++entry;
      }
    }
  }

  // Returns the largest change.
  double Step() {
    std::vector<double> right(count_, 0.0), diagonal(count_);
    for (std::size_t i = 0; i < count_; ++i) diagonal[i] = PriorOf(i);
    FindRows();
    std::size_t entry = 0;
    for (const LightSample& sample : samples_) {
      if (sample.held_out) continue;
      for (const LightObservation& seen : sample.seen) {
        const Row& row = rows_[entry];
        const double weight = weight_[entry], residual = over_error_[entry] * seen.error;
        for (const std::size_t i : {0, 1, 2}) {
          right[row.at[i]] += weight * row.value[i] * residual;
          diagonal[row.at[i]] += weight * row.value[i] * row.value[i];
        }
        ++entry;
      }
    }
    for (std::size_t i = 0; i < count_; ++i) right[i] -= PriorOf(i) * Parameter(i);
    const std::vector<double> step = Solve(right, diagonal);
    double largest = 0;
    for (std::size_t i = 0; i < count_; ++i) {
      Parameter(i) += step[i];
      largest = std::max(largest, std::abs(step[i]));
    }
    for (auto& gains : solution_.log_gain) {
      const double mean = std::accumulate(gains.begin(), gains.end(), 0.0) / views_;
      for (double& gain : gains) gain -= mean;
    }
    return largest;
  }

  double least_error = 1;

 private:
  // Weights of the prior (no gain, no fall-off) in numbers of perfect observations, which determines
  // unobserved unknowns. The fall-off follows from small differences, and needs a weak one.
  static constexpr double kPriorOfGain = 1, kPriorOfFalloff = 1e-3;
  double PriorOf(std::size_t i) const { return i < 3 * At(views_) ? kPriorOfGain : kPriorOfFalloff; }

  struct Row {  // derivatives of an observation; the first is 1
    std::array<std::size_t, 3> at{};
    std::array<double, 3> value{1, 0, 0};
  };

  double& Parameter(std::size_t i) {
    const auto views = static_cast<std::size_t>(views_);
    if (i < 3 * views) return solution_.log_gain[i / views][i % views];
    i -= 3 * views;
    return solution_.falloff[i / 2][static_cast<Eigen::Index>(i % 2)];
  }

  // Without fall-off its derivatives are zero.
  Row RowOf(int channel, const LightObservation& seen) const {
    Row row;
    row.at[0] = At(channel) * At(views_) + At(seen.view);
    const double falloff = FalloffOf(solution_.falloff[At(seen.camera)], seen.r2);
    for (const std::size_t i : {0, 1}) {
      row.at[i + 1] = 3 * At(views_) + 2 * At(seen.camera) + i;
      if (has_falloff_) row.value[i + 1] = (i == 0 ? seen.r2 : seen.r2 * seen.r2) / falloff;
    }
    return row;
  }

  // Computed once a step, because each is used in every multiplication of the solver.
  void FindRows() {
    rows_.clear();
    rows_.reserve(entries_);
    for (const LightSample& sample : samples_)
      if (!sample.held_out)
        for (const LightObservation& seen : sample.seen) rows_.push_back(RowOf(sample.channel, seen));
  }

  // Multiplies by the normal matrix.
  void Multiply(const std::vector<double>& x, std::vector<double>& product) const {
    for (std::size_t i = 0; i < count_; ++i) product[i] = PriorOf(i) * x[i];
    std::size_t entry = 0;
    std::vector<double> values;
    for (const LightSample& sample : samples_) {
      if (sample.held_out) continue;
      double sum = 0, total = 0;
      values.clear();
      for (std::size_t i = 0; i < sample.seen.size(); ++i) {
        const Row& row = rows_[entry + i];
        values.push_back(x[row.at[0]] + row.value[1] * x[row.at[1]] + row.value[2] * x[row.at[2]]);
        sum += weight_[entry + i] * values.back();
        total += weight_[entry + i];
      }
      const double mean = total > 0 ? sum / total : 0;
      for (std::size_t i = 0; i < values.size(); ++i) {
        const Row& row = rows_[entry + i];
        const double weighted = weight_[entry + i] * (values[i] - mean);
        for (const std::size_t n : {0, 1, 2}) product[row.at[n]] += row.value[n] * weighted;
      }
      entry += values.size();
    }
  }

  // Conjugate gradients avoid the matrix, which would be large for many views.
  std::vector<double> Solve(const std::vector<double>& right, const std::vector<double>& diagonal) const {
    constexpr int kMostSteps = 200;
    constexpr double kEnough = 1e-5;  // of the first residual
    std::vector<double> x(count_, 0.0), rest = right, scaled(count_), product(count_);
    const auto dot = [&](const std::vector<double>& a, const std::vector<double>& b) {
      return std::inner_product(a.begin(), a.end(), b.begin(), 0.0);
    };
    const auto scale = [&] {
      for (std::size_t i = 0; i < count_; ++i) scaled[i] = rest[i] / diagonal[i];
    };
    scale();
    std::vector<double> along = scaled;
    double size = dot(rest, scaled);
    const double enough = kEnough * kEnough * size;
    for (int i = 0; i < kMostSteps && size > enough; ++i) {
      Multiply(along, product);
      const double step = size / dot(along, product);
      for (std::size_t n = 0; n < count_; ++n) {
        x[n] += step * along[n];
        rest[n] -= step * product[n];
      }
      scale();
      const double before = std::exchange(size, dot(rest, scaled));
      for (std::size_t n = 0; n < count_; ++n) along[n] = scaled[n] + size / before * along[n];
    }
    return x;
  }

  const std::vector<LightSample>& samples_;
  int views_;
  bool has_falloff_;
  LightSolution solution_;
  std::size_t count_ = 0, entries_ = 0;
  std::vector<double> weight_, over_error_;
  std::vector<Row> rows_;
};

}  // namespace

double FalloffOf(const Eigen::Vector2d& falloff, double r2) {
  return 1 + r2 * (falloff[0] + r2 * falloff[1]);
}

LightSolution SolveLight(const std::vector<LightSample>& samples, int views, int cameras, LightModel model) {
  Normal normal(samples, views, cameras, model);
  if (model == LightModel::kAsRecorded) return normal.solution();
  normal.least_error = 1e30;
  for (const LightSample& sample : samples)
    for (const LightObservation& seen : sample.seen)
      normal.least_error = std::min(normal.least_error, seen.error);
  // Absolute deviations converge from far; Geman and McClure's weights then ignore outliers.
  constexpr int kAbsolute = 12, kRedescending = 12;
  constexpr double kEnough = 1e-5, kLeastScale = 1e-3, kTimesScale = 2.5;
  for (int i = 0; i < kAbsolute; ++i) {
    normal.Residuals(i == 0);
    const double scale = std::max(kLeastScale, normal.Scale());
    normal.Reweigh([&](double r) { return scale / std::max(scale, std::abs(r)); });
    normal.Residuals(false);
    if (normal.Step() < kEnough) break;
  }
  for (int i = 0; i < kRedescending; ++i) {
    normal.Residuals(false);
    const double scale = std::max(kLeastScale, kTimesScale * normal.Scale());
    normal.Reweigh([&](double r) {
      const double root = 1 / (1 + r * r / (scale * scale));
      return root * root;
    });
    normal.Residuals(false);
    if (normal.Step() < kEnough) break;
  }
  return normal.solution();
}

std::vector<HeldOutError> HeldOutErrors(const std::vector<LightSample>& samples,
                                        const LightSolution& solution) {
  std::vector<HeldOutError> errors;
  std::vector<double> values;
  for (const LightSample& sample : samples) {
    if (!sample.held_out) continue;
    values.clear();
    for (const LightObservation& seen : sample.seen)
      values.push_back(Corrected(solution, sample.channel, seen));
    std::vector<double> copy = values;
    const double middle = MiddleOf(copy);
    for (std::size_t i = 0; i < values.size(); ++i)
      errors.push_back({(values[i] - middle) / sample.seen[i].error, sample.seen[i].error});
  }
  return errors;
}

}  // namespace ulf::render
