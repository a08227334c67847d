#include "render/quality/light_fit.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/base/at.h"
#include "core/base/counted.h"
#include "core/base/quantile.h"

namespace ulf::render {
namespace {

// The simplest model is kept whose error at held-out points is within this share, or this much, of the best.
// Guessed; the second is a quarter of a level of 255.
constexpr double kWithinShare = 0.03, kWithin = 0.001;

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kStop = M_LN2;

// Returns the root of the weighted mean square of the log of light, in which an outlier counts as `most`.
double RootMeanSquare(const std::vector<HeldOutError>& errors, double most) {
  double sum = 0, total = 0;
  for (const auto& [over_error, error] : errors) {
    sum += std::min(over_error * over_error, most * most);
    total += 1 / (error * error);
  }
  return total > 0 ? std::sqrt(sum / total) : 0;
}

// A polynomial that leaves a corner hardly any light, or much more than the middle, describes no lens.
bool IsLens(const Vector2d& falloff, double most_r2) {
  constexpr double kLeast = 0.1, kMost = 2;
  constexpr int kSteps = 32;
  for (int i = 1; i <= kSteps; ++i) {
    const double at = FalloffOf(falloff, most_r2 * i / kSteps);
    if (at < kLeast || at > kMost) return false;
  }
  return true;
}

double CornerR2(const CameraModel& camera) {
  const Vector2d farthest(std::max(camera.cx, camera.width - camera.cx),
                          std::max(camera.cy, camera.height - camera.cy));
  return farthest.squaredNorm() / HalfDiagonal(camera).squaredNorm();
}

using CenterAndGain = std::pair<Vector3d, cv::Vec3f>;

// Returns the log gain of a view at a place, from those of the nearest views, weighted by nearness; `without`
// is the index of a view to leave out, if 0 or more.
cv::Vec3d LogGainAmong(const std::vector<CenterAndGain>& views, const Vector3d& center, int without) {
  constexpr std::size_t kNearest = 4;
  std::vector<std::pair<double, std::size_t>> by_distance;
  for (std::size_t i = 0; i < views.size(); ++i)
    if (static_cast<int>(i) != without) by_distance.emplace_back((views[i].first - center).norm(), i);
  const auto count = std::min(kNearest, by_distance.size());
  std::ranges::partial_sort(by_distance, by_distance.begin() + static_cast<std::ptrdiff_t>(count));
  cv::Vec3d sum(0, 0, 0);
  double total = 0;
  for (std::size_t n = 0; n < count; ++n) {
    const auto& [distance, i] = by_distance[n];
    const double weight = 1 / std::max(distance, 1e-9);
    for (int c = 0; c < 3; ++c) sum[c] += weight * std::log(views[i].second[c]);
    total += weight;
  }
  return total > 0 ? sum / total : sum;
}

// Returns whether the views' gains are predicted better by their neighbours than by their mean.
bool NeighboursTellGains(const std::vector<CenterAndGain>& views) {
  constexpr double kClearly = 0.8;  // of the mean square error. Guessed.
  double by_neighbours = 0, by_mean = 0;
  for (std::size_t i = 0; i < views.size(); ++i) {
    const cv::Vec3d predicted = LogGainAmong(views, views[i].first, static_cast<int>(i));
    for (int c = 0; c < 3; ++c) {
      const double gain = std::log(views[i].second[c]);
      by_neighbours += (gain - predicted[c]) * (gain - predicted[c]);
      by_mean += gain * gain;
    }
  }
  return by_neighbours < kClearly * by_mean;
}

std::string NameOf(LightModel model) {
  switch (model) {
    case LightModel::kAsRecorded:
      return "as recorded";
    case LightModel::kGains:
      return "a gain for each view and channel";
    default:
      return "gains, and the lens's fall-off";
  }
}

}  // namespace

LightFit FitLight(const RenderScene& scene) {
  LightFit fit;
  std::vector<CameraModel> cameras;
  std::vector<int> camera_of;
  for (const SceneView& view : scene.views) {
    const auto same = std::ranges::find(cameras, view.camera);
    camera_of.push_back(static_cast<int>(same - cameras.begin()));
    if (same == cameras.end()) cameras.push_back(view.camera);
  }
  std::vector<LightSample> samples = SampleLight(scene, camera_of, fit.points);
  fit.explained = {
      "light of the views",
      fmt::format("the first within {:g} % of the best at points that were held out, in this order",
                  100 * kWithinShare),
      {}};
  constexpr std::array models{LightModel::kAsRecorded, LightModel::kGains, LightModel::kGainsAndFalloff};
  if (std::ranges::none_of(samples, &LightSample::held_out) ||
      std::ranges::all_of(samples, &LightSample::held_out)) {
    fit.explained.candidates.push_back(
        {NameOf(LightModel::kAsRecorded), "not tried: views have no points in common", true});
    return fit;
  }
  const int views = static_cast<int>(scene.views.size()), camera_count = static_cast<int>(cameras.size());
  const auto has_lenses = [&](const LightSolution& solution) {
    for (std::size_t i = 0; i < cameras.size(); ++i)
      if (!IsLens(solution.falloff[i], CornerR2(cameras[i]))) return false;
    return true;
  };
  std::vector<std::vector<HeldOutError>> errors;
  for (const LightModel model : models) {
    const LightSolution solution = SolveLight(samples, views, camera_count, model);
    if (!has_lenses(solution)) break;  // for the richest model
    errors.push_back(HeldOutErrors(samples, solution));
  }
  // Residuals above three standard deviations under the richest model are outliers under each.
  std::vector<double> sizes;
  for (const auto& [over_error, error] : errors.back()) sizes.push_back(std::abs(over_error));
  const double most = 3 * 1.4826 * Median(std::move(sizes));
  std::vector<double> sums;
  for (const auto& of_model : errors) sums.push_back(RootMeanSquare(of_model, most));
  const double best = *std::ranges::min_element(sums);
  const double enough = std::max((1 + kWithinShare) * best, best + kWithin);
  const auto chosen = static_cast<std::size_t>(
      std::ranges::find_if(sums, [&](double sum) { return sum <= enough; }) - sums.begin());
  fit.model = models[chosen];
  for (std::size_t i = 0; i < models.size(); ++i)
    fit.explained.candidates.push_back({NameOf(models[i]),
                                        i < sums.size() ? fmt::format("{:.2f} % of light", 100 * sums[i])
                                                        : "no lens has the fall-off that was found",
                                        i == chosen});
  if (fit.model == LightModel::kAsRecorded) return fit;
  for (LightSample& sample : samples) sample.held_out = false;  // they are used from here on
  const LightSolution solution = SolveLight(samples, views, camera_count, fit.model);
  for (const auto& gains : solution.log_gain) {
    const auto [least, greatest] = std::ranges::minmax(gains);
    fit.stops = std::max(fit.stops, (greatest - least) / kStop);
  }
  for (std::size_t i = 0; i < scene.views.size(); ++i) {
    cv::Vec3f& gain = fit.gains[scene.views[i].id];
    for (int c = 0; c < 3; ++c) gain[c] = static_cast<float>(std::exp(solution.log_gain[At(c)][i]));
  }
  for (std::size_t i = 0; i < cameras.size() && fit.model == LightModel::kGainsAndFalloff; ++i) {
    const double corner_r2 = CornerR2(cameras[i]);
    fit.falloffs.emplace_back(cameras[i], solution.falloff[i].cast<float>());
    fit.corner_stops =
        std::max(fit.corner_stops, -std::log(FalloffOf(solution.falloff[i], corner_r2)) / kStop);
  }
  return fit;
}

std::string LightFit::Words() const {
  if (model == LightModel::kAsRecorded)
    return points == 0 ? "light is as recorded: views have no points in common"
                       : fmt::format("the views' exposures agree, by {}: light is as recorded",
                                     Counted(points, "point"));
  const std::string corners =
      falloffs.empty() ? "" : fmt::format(", corners are up to {:.2f} stops darker", corner_stops);
  return fmt::format("views differ by up to {:.2f} stops{}: evened out by {}", stops, corners,
                     Counted(points, "point"));
}

std::shared_ptr<const RenderScene> WithLight(const RenderScene& scene, const LightFit& fit) {
  auto other = std::make_shared<RenderScene>(scene);
  std::vector<CenterAndGain> fitted;
  for (const SceneView& view : scene.views)
    if (const auto found = fit.gains.find(view.id); found != fit.gains.end())
      fitted.emplace_back(view.center_in_world, found->second);
  const bool neighbours_tell = fitted.size() < scene.views.size() && NeighboursTellGains(fitted);
  for (SceneView& view : other->views) {
    view.correction = {};
    if (const auto found = fit.gains.find(view.id); found != fit.gains.end()) {
      view.correction.gain = found->second;
    } else if (neighbours_tell) {
      const cv::Vec3d log_gain = LogGainAmong(fitted, view.center_in_world, -1);
      for (int c = 0; c < 3; ++c) view.correction.gain[c] = static_cast<float>(std::exp(log_gain[c]));
    }
    for (const auto& [camera, falloff] : fit.falloffs)
      if (camera == view.camera) {
        view.correction.falloff_r2 = falloff[0];
        view.correction.falloff_r4 = falloff[1];
      }
  }
  return other;
}

}  // namespace ulf::render
