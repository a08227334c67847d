#include "render/quality/light_fit.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <random>

#include "core/base/at.h"
#include "core/base/counted.h"
#include "core/base/parallel_for.h"
#include "core/base/quantile.h"
#include "core/geometry/pinhole.h"
#include "render/proxy/depth_raster.h"
#include "render/renderer/reference_renderer.h"

namespace ulf::render {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kStop = M_LN2;
constexpr int kHeldOutEvery = 5;  // points

double MiddleOf(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  if (values.size() % 2 == 1) return *middle;
  return 0.5 * (*middle + *std::max_element(values.begin(), middle));
}

double FalloffOf(const Vector2d& falloff, double r2) { return 1 + r2 * (falloff[0] + r2 * falloff[1]); }

// The photograph's log light without what the solution explains.
double Corrected(const LightSolution& solution, int channel, const LightObservation& seen) {
  return seen.log_light - solution.log_gain[At(channel)][At(seen.view)] -
         std::log(FalloffOf(solution.falloff[At(seen.camera)], seen.r2));
}

// Gauss-Newton steps on weighted squares. A point's own light is eliminated: what is left of an observation is its
// difference from the point's weighted mean.
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

  // Of every observation from its point's weighted mean, over its expected error; from the middle one at first.
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

  // `weight` of a residual over its expected error.
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
    ForEach([&](const Row& row, double weight, double residual) {
      for (int i = 0; i < row.count; ++i) {
        right[row.at[At(i)]] += weight * row.value[At(i)] * residual;
        diagonal[row.at[At(i)]] += weight * row.value[At(i)] * row.value[At(i)];
      }
    });
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
  // Of so many perfect observations that say: no gain, no fall-off. They hold what nobody compares. The shape of a
  // fall-off hangs by small differences, and must not be bent.
  static constexpr double kPriorOfGain = 1, kPriorOfFalloff = 1e-3;
  double PriorOf(std::size_t i) const { return i < 3 * At(views_) ? kPriorOfGain : kPriorOfFalloff; }

  struct Row {  // derivatives of an observation
    int count = 0;
    std::array<std::size_t, 3> at{};
    std::array<double, 3> value{};
  };

  double& Parameter(std::size_t i) {
    const auto views = static_cast<std::size_t>(views_);
    if (i < 3 * views) return solution_.log_gain[i / views][i % views];
    i -= 3 * views;
    return solution_.falloff[i / 2][static_cast<Eigen::Index>(i % 2)];
  }

  Row RowOf(int channel, const LightObservation& seen) const {
    Row row;
    row.at[0] = At(channel) * At(views_) + At(seen.view);
    row.value[0] = 1;
    row.count = 1;
    if (!has_falloff_) return row;
    const double falloff = FalloffOf(solution_.falloff[At(seen.camera)], seen.r2);
    for (const std::size_t i : {0, 1}) {
      row.at[i + 1] = 3 * At(views_) + 2 * At(seen.camera) + i;
      row.value[i + 1] = (i == 0 ? seen.r2 : seen.r2 * seen.r2) / falloff;
    }
    row.count = 3;
    return row;
  }

  template <typename Each>
  void ForEach(const Each& each) const {
    std::size_t entry = 0;
    for (const LightSample& sample : samples_) {
      if (sample.held_out) continue;
      for (const LightObservation& seen : sample.seen) {
        each(RowOf(sample.channel, seen), weight_[entry], over_error_[entry] * seen.error);
        ++entry;
      }
    }
  }

  // The normal matrix times x.
  void Multiply(const std::vector<double>& x, std::vector<double>& product) const {
    for (std::size_t i = 0; i < count_; ++i) product[i] = PriorOf(i) * x[i];
    std::size_t entry = 0;
    std::vector<std::pair<Row, double>> of_point;
    for (const LightSample& sample : samples_) {
      if (sample.held_out) continue;
      double sum = 0, total = 0;
      of_point.clear();
      for (std::size_t i = 0; i < sample.seen.size(); ++i) {
        const Row row = RowOf(sample.channel, sample.seen[i]);
        double value = 0;
        for (int n = 0; n < row.count; ++n) value += row.value[At(n)] * x[row.at[At(n)]];
        of_point.emplace_back(row, value);
        sum += weight_[entry + i] * value;
        total += weight_[entry + i];
      }
      const double mean = total > 0 ? sum / total : 0;
      for (std::size_t i = 0; i < sample.seen.size(); ++i) {
        const auto& [row, value] = of_point[i];
        for (int n = 0; n < row.count; ++n)
          product[row.at[At(n)]] += weight_[entry + i] * row.value[At(n)] * (value - mean);
      }
      entry += sample.seen.size();
    }
  }

  // Conjugate gradients: the matrix of many views would be large, and is never needed.
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
};

// The held-out points' errors under a solution: differences from each point's middle, over the expected errors.
std::vector<std::pair<double, double>> HeldOutErrors(const std::vector<LightSample>& samples,
                                                     const LightSolution& solution) {
  std::vector<std::pair<double, double>> errors;  // over the expected, expected
  std::vector<double> values;
  for (const LightSample& sample : samples) {
    if (!sample.held_out) continue;
    values.clear();
    for (const LightObservation& seen : sample.seen)
      values.push_back(Corrected(solution, sample.channel, seen));
    std::vector<double> copy = values;
    const double middle = MiddleOf(copy);
    for (std::size_t i = 0; i < values.size(); ++i)
      errors.emplace_back((values[i] - middle) / sample.seen[i].error, sample.seen[i].error);
  }
  return errors;
}

// Root of the weighted mean square of the log of light, in which an outlier counts as `most`.
double RootMeanSquare(const std::vector<std::pair<double, double>>& errors, double most) {
  double sum = 0, total = 0;
  for (const auto& [over_error, error] : errors) {
    sum += std::min(over_error * over_error, most * most);
    total += 1 / (error * error);
  }
  return total > 0 ? std::sqrt(sum / total) : 0;
}

// A polynomial that leaves a corner hardly any light, or much more than the middle has, is no lens.
bool IsLens(const Vector2d& falloff, double most_r2) {
  constexpr double kLeast = 0.1, kMost = 2;
  constexpr int kSteps = 32;
  for (int i = 1; i <= kSteps; ++i) {
    const double at = FalloffOf(falloff, most_r2 * i / kSteps);
    if (at < kLeast || at > kMost) return false;
  }
  return true;
}

Vector2d HalfDiagonal(const CameraModel& camera) { return {0.5 * camera.width, 0.5 * camera.height}; }

double CornerR2(const CameraModel& camera) {
  const Vector2d farthest(std::max(camera.cx, camera.width - camera.cx),
                          std::max(camera.cy, camera.height - camera.cy));
  return farthest.squaredNorm() / HalfDiagonal(camera).squaredNorm();
}

// The level of a photograph whose pixels are compared.
struct SmallPicture {
  cv::Mat pixels;
  double pixel = 1;  // of the level, in pixels of the view's camera
};

// Log light of B G R at a point of a photograph, and what it changes by over a pixel; none where a channel is clipped,
// nearly black, or not there.
struct LogLight {
  std::array<double, 3> value{}, slope{};
  std::array<bool, 3> counts{};
};
std::optional<LogLight> LogLightAt(const SceneView& view, const SmallPicture& picture, const Vector2d& img,
                                   const LightFitOptions& options) {
  const auto sample = [&](double x, double y) {
    return SampleLevel(picture.pixels, view.camera, img + picture.pixel * Vector2d(x, y));
  };
  constexpr float kWhole = 0.999f;  // of the share that has light
  const std::array<cv::Vec4f, 5> around{sample(0, 0), sample(-1, 0), sample(1, 0), sample(0, -1),
                                        sample(0, 1)};
  if (std::ranges::any_of(around, [](const cv::Vec4f& light) { return light[3] < kWhole; }))
    return std::nullopt;
  LogLight light;
  for (int c = 0; c < 3; ++c) {
    const std::size_t channel = At(c);
    std::array<double, 5> logs{};
    light.counts[channel] = true;
    for (std::size_t i = 0; i < around.size(); ++i) {
      const float above_black = around[i][c] - view.black;
      light.counts[channel] &= around[i][c] <= options.most_light && above_black >= options.least_light;
      logs[i] = std::log(std::max(above_black, options.least_light) * view.scale);
    }
    light.value[channel] = logs[0];
    light.slope[channel] = 0.5 * std::max(std::abs(logs[2] - logs[1]), std::abs(logs[4] - logs[3]));
  }
  return light;
}

// Where the proxy's depth bends sharply about a pixel there may be an edge.
bool IsAtEdge(const cv::Mat& inverse_depth, int x, int y) {
  constexpr float kBend = 0.02f;  // of the inverse depth, which is linear over a plane. Guessed.
  const float here = inverse_depth.at<float>(y, x);
  for (const auto& [dx, dy] : {std::pair{1, 0}, {0, 1}, {1, 1}, {1, -1}}) {
    const float before = inverse_depth.at<float>(y - dy, x - dx);
    const float after = inverse_depth.at<float>(y + dy, x + dx);
    if (before <= 0 || after <= 0 || std::abs(before + after - 2 * here) > kBend * here) return true;
  }
  return false;
}

// Points of the surface that a view sees, spread evenly over its picture.
std::vector<Vector3d> PointsOf(const RenderScene& scene, const SceneView& view, int tries) {
  constexpr int kDepthPx = 240;  // longer side of the depth map
  const CameraModel flat = view.camera.WithoutDistortion();
  const double by = std::min(1.0, 1.0 * kDepthPx / std::max(flat.width, flat.height));
  const CameraModel camera = flat.ScaledTo(std::max(3, static_cast<int>(std::lround(by * flat.width))),
                                           std::max(3, static_cast<int>(std::lround(by * flat.height))));
  const auto triangles = scene.proxy->Triangles(camera, view.cam_from_world);
  std::vector<Vector3d> points;
  if (!triangles) return points;
  const cv::Mat inverse_depth = DrawInverseDepth(*triangles, camera, view.cam_from_world);
  const Rigid3 world_from_cam = view.cam_from_world.Inverse();
  // Roberts' sequence: even for any number of points.
  constexpr double kX = 0.7548776662466927, kY = 0.5698402909980532;
  const auto pixel = [](double share, int size) {
    return 1 + static_cast<int>((share - std::floor(share)) * (size - 2));
  };
  for (int i = 0; i < tries; ++i) {
    const int x = pixel(0.5 + kX * i, camera.width), y = pixel(0.5 + kY * i, camera.height);
    const float inverse = inverse_depth.at<float>(y, x);
    if (inverse <= 0 || IsAtEdge(inverse_depth, x, y)) continue;
    points.push_back(world_from_cam * (PinholeRay(camera, x, y) / inverse));
  }
  return points;
}

// A point as the views see it: a sample for each channel in which no view is clipped or nearly black. If single views
// were left out for that, a limit would cut the bright views of one point and the dark ones of the next.
std::vector<LightSample> SamplesOf(const RenderScene& scene, const std::vector<SmallPicture>& pictures,
                                   const std::vector<int>& camera_of, int source, const Vector3d& point,
                                   std::mt19937& random, const LightFitOptions& options) {
  constexpr double kSeen = 0.999;  // neither at an edge of the proxy nor at that of the image
  std::array<LightSample, 3> samples;
  std::array<bool, 3> counts{true, true, true};
  std::uniform_int_distribution<int> any(0, static_cast<int>(scene.views.size()) - 1);
  const bool asks_all = static_cast<int>(scene.views.size()) <= options.most_asked;
  const int first = any(random);
  std::vector<int> asked;
  for (int i = 0; i < std::min(options.most_asked, static_cast<int>(scene.views.size())); ++i) {
    // All in turn from a random one on, or random ones.
    const int index = i == 0     ? source
                      : asks_all ? (first + i) % static_cast<int>(scene.views.size())
                                 : any(random);
    if (std::ranges::count(asked, index) > 0) continue;
    asked.push_back(index);
    const SceneView& view = scene.views[At(index)];
    const auto seen = view.See(point);
    if (!seen || seen->feather < kSeen) continue;
    const auto light = LogLightAt(view, pictures[At(index)], seen->img, options);
    if (!light) continue;
    const double r2 = (seen->img - Vector2d(view.camera.cx, view.camera.cy)).squaredNorm() /
                      HalfDiagonal(view.camera).squaredNorm();
    for (std::size_t c = 0; c < 3; ++c) {
      counts[c] &= light->counts[c];
      samples[c].seen.push_back({index, camera_of[At(index)], r2, light->value[c],
                                 std::hypot(options.smooth_error, light->slope[c])});
    }
    if (static_cast<int>(samples[0].seen.size()) == options.views_per_point) break;
  }
  std::vector<LightSample> kept;
  for (std::size_t c = 0; c < 3; ++c) {
    if (!counts[c] || samples[c].seen.size() < 2) continue;
    samples[c].channel = static_cast<int>(c);
    kept.push_back(std::move(samples[c]));
  }
  return kept;
}

std::vector<SmallPicture> SmallPictures(const RenderScene& scene, int size_px) {
  std::vector<SmallPicture> pictures(scene.views.size());
  ParallelFor(scene.views.size(), [&](std::size_t i) {
    const Photograph& photograph = *scene.views[i].photograph;
    int level = 0;
    const auto longer = [&] {
      return std::max(photograph.LevelSize(level).width, photograph.LevelSize(level).height);
    };
    while (longer() > size_px && level + 1 < photograph.LevelCount()) ++level;
    pictures[i] = {photograph.Level(level),
                   1.0 * scene.views[i].camera.width / photograph.LevelSize(level).width};
  });
  return pictures;
}

// The samples of all points, the same whatever the number of threads.
std::vector<LightSample> Sample(const RenderScene& scene, const std::vector<int>& camera_of,
                                const LightFitOptions& options, std::size_t& points) {
  const std::vector<SmallPicture> pictures = SmallPictures(scene, options.size_px);
  const int tries =
      std::clamp(options.most_points / static_cast<int>(scene.views.size()), 1, options.points_per_view);
  std::vector<std::vector<LightSample>> of_views(scene.views.size());
  std::vector<std::size_t> counts(scene.views.size(), 0);
  ParallelFor(scene.views.size(), [&](std::size_t i) {
    std::mt19937 random(static_cast<unsigned>(i + 1));
    for (const Vector3d& point : PointsOf(scene, scene.views[i], tries)) {
      auto samples = SamplesOf(scene, pictures, camera_of, static_cast<int>(i), point, random, options);
      if (samples.empty()) continue;
      const bool held_out = counts[i]++ % kHeldOutEvery == 0;
      for (LightSample& sample : samples) {
        sample.held_out = held_out;
        of_views[i].push_back(std::move(sample));
      }
    }
  });
  std::vector<LightSample> all;
  points = 0;
  for (std::size_t i = 0; i < of_views.size(); ++i) {
    std::ranges::move(of_views[i], std::back_inserter(all));
    points += counts[i];
  }
  return all;
}

using CenterAndGain = std::pair<Vector3d, cv::Vec3f>;

// The log gain of a view at a place, from those of the nearest views, the nearer the more; `without`: of which one is
// left out, if 0 or more.
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

// Whether the views' gains are predicted better by their neighbours than by their mean.
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

LightSolution SolveLight(const std::vector<LightSample>& samples, int views, int cameras, LightModel model) {
  Normal normal(samples, views, cameras, model);
  if (model == LightModel::kAsRecorded) return normal.solution();
  normal.least_error = 1e30;
  for (const LightSample& sample : samples)
    for (const LightObservation& seen : sample.seen)
      normal.least_error = std::min(normal.least_error, seen.error);
  // Absolute deviations find the way from far, Geman and McClure's weights forget what is far off.
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

LightFit FitLight(const RenderScene& scene, const LightFitOptions& options) {
  LightFit fit;
  std::vector<CameraModel> cameras;
  std::vector<int> camera_of;
  for (const SceneView& view : scene.views) {
    const auto same = std::ranges::find(cameras, view.camera);
    camera_of.push_back(static_cast<int>(same - cameras.begin()));
    if (same == cameras.end()) cameras.push_back(view.camera);
  }
  std::vector<LightSample> samples = Sample(scene, camera_of, options, fit.points);
  fit.explained = {
      "light of the views",
      fmt::format("the first within {:g} % of the best at points that were held out, in this order",
                  100 * options.within_share),
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
  std::vector<std::vector<std::pair<double, double>>> errors;
  for (const LightModel model : models) {
    const LightSolution solution = SolveLight(samples, views, camera_count, model);
    if (!has_lenses(solution)) break;  // of the richest
    errors.push_back(HeldOutErrors(samples, solution));
  }
  // What is farther off than three standard deviations under the richest model is an outlier under each.
  std::vector<double> sizes;
  for (const auto& [over_error, error] : errors.back()) sizes.push_back(std::abs(over_error));
  const double most = 3 * 1.4826 * Median(std::move(sizes));
  std::vector<double> sums;
  for (const auto& of_model : errors) sums.push_back(RootMeanSquare(of_model, most));
  const double best = *std::ranges::min_element(sums);
  const double enough = std::max((1 + options.within_share) * best, best + options.within);
  const auto chosen = static_cast<std::size_t>(
      std::ranges::find_if(sums, [&](double sum) { return sum <= enough; }) - sums.begin());
  fit.model = models[chosen];
  for (std::size_t i = 0; i < models.size(); ++i)
    fit.explained.candidates.push_back({NameOf(models[i]),
                                        i < sums.size() ? fmt::format("{:.2f} % of light", 100 * sums[i])
                                                        : "no lens has the fall-off that was found",
                                        i == chosen});
  if (fit.model == LightModel::kAsRecorded) return fit;
  for (LightSample& sample : samples) sample.held_out = false;  // they have done their work
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
