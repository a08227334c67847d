// Estimates a model robustly (RANSAC): draws minimal samples, solves them, keeps that of least truncated cost
// (MSAC, Torr and Zisserman 2000), and improves each new best on its inliers (Chum, Matas and Kittler 2003).
//
// It replaces OpenGV's RANSAC, which scores by counting, never improves a model, and draws eight points where
// five suffice. Every draw comes from the caller's seed: the same data and seed give the same model. A model
// is dropped once its running cost exceeds the best one's; points are visited in random order.
#pragma once

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <random>
#include <vector>

#include "core/base/at.h"

namespace ulf::tracking {

struct SamplingOptions {
  double threshold = 1;  // in the residual's unit: a point with a larger residual is an outlier
  int max_iterations = 2000;
  unsigned seed = 1;
};

template <typename Model>
struct SamplingResult {
  Model model;
  double cost = 0;           // sum over points of min(residual², threshold²)
  std::vector<int> inliers;  // indices of points
  int iterations = 0;        // number of samples drawn
};

namespace internal {

inline constexpr double kConfidence = 0.999;  // that at least one sample held inliers alone
// Each new best model is improved at most so often. Guessed: more rounds rarely gain anything.
inline constexpr int kImprovements = 3;

// Fills `sample` with distinct numbers below `n`, unlike std distributions the same with every library.
inline void DrawSample(std::mt19937& random, int n, std::vector<int>& sample) {
  for (std::size_t i = 0; i < sample.size();) {
    const int drawn = static_cast<int>(random() % static_cast<unsigned>(n));
    if (std::find(sample.begin(), sample.begin() + static_cast<long>(i), drawn) ==
        sample.begin() + static_cast<long>(i))
      sample[i++] = drawn;
  }
}

inline int IterationsNeeded(double inlier_share, int sample_size, double confidence, int limit) {
  const double all_good = std::pow(inlier_share, sample_size);
  if (all_good >= 1) return 1;
  if (all_good < 1e-12) return limit;
  return static_cast<int>(
      std::min<double>(limit, std::ceil(std::log(1 - confidence) / std::log1p(-all_good))));
}

}  // namespace internal

// Returns the best model for `count` points, which the caller's functions know by their indices; none if no
// model has at least `sample_size` inliers. solve(sample) returns a range of models that explain the sampled
// points, residual2(model, i) the squared residual of a point (infinity: impossible), improve(model, inliers)
// an optional better model.
template <typename Model, typename Solve, typename Residual2, typename Improve>
std::optional<SamplingResult<Model>> SampleConsensus(int count, int sample_size, Solve&& solve,
                                                     Residual2&& residual2, Improve&& improve,
                                                     const SamplingOptions& options) {
  if (count < sample_size) return std::nullopt;
  std::mt19937 random(options.seed);
  std::vector<int> order(At(count));
  std::iota(order.begin(), order.end(), 0);
  for (int i = count - 1; i > 0; --i) std::swap(order[At(i)], order[random() % static_cast<unsigned>(i + 1)]);

  const double limit2 = options.threshold * options.threshold;
  std::optional<SamplingResult<Model>> best;
  const auto consider = [&](const Model& model) {
    const double to_beat = best ? best->cost : limit2 * count;
    double cost = 0;
    for (const int i : order) {
      cost += std::min(residual2(model, i), limit2);
      if (!(cost < to_beat)) return false;
    }
    SamplingResult<Model> result{model, cost, {}, 0};
    for (int i = 0; i < count; ++i)
      if (residual2(model, i) < limit2) result.inliers.push_back(i);
    if (static_cast<int>(result.inliers.size()) < sample_size) return false;
    best = std::move(result);
    return true;
  };

  std::vector<int> sample(At(sample_size));
  int needed = options.max_iterations;
  int iteration = 0;
  for (; iteration < needed; ++iteration) {
    internal::DrawSample(random, count, sample);
    bool better = false;
    for (const Model& model : solve(sample)) better = consider(model) || better;
    if (!better) continue;
    for (int round = 0; round < internal::kImprovements; ++round) {
      const std::optional<Model> improved = improve(best->model, best->inliers);
      if (!improved || !consider(*improved)) break;
    }
    needed = internal::IterationsNeeded(static_cast<double>(best->inliers.size()) / count, sample_size,
                                        internal::kConfidence, options.max_iterations);
  }
  if (best) best->iterations = iteration;
  return best;
}

// Does the same with one function fit(indices), an optional model, in place of solve and improve.
template <typename Model, typename Fit, typename Residual2>
std::optional<SamplingResult<Model>> SampleConsensusByFit(int count, int sample_size, Fit&& fit,
                                                          Residual2&& residual2,
                                                          const SamplingOptions& options) {
  const auto solve = [&](const std::vector<int>& sample) {
    std::vector<Model> models;
    if (const std::optional<Model> model = fit(sample)) models.push_back(*model);
    return models;
  };
  const auto improve = [&](const Model&, const std::vector<int>& inliers) { return fit(inliers); };
  return SampleConsensus<Model>(count, sample_size, solve, residual2, improve, options);
}

}  // namespace ulf::tracking
