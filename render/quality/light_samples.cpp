#include "render/quality/light_samples.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <random>

#include "core/base/at.h"
#include "core/base/parallel_for.h"
#include "core/geometry/pinhole.h"
#include "render/proxy/depth_raster.h"
#include "render/renderer/reference_renderer.h"

namespace ulf::render {
namespace {

constexpr int kComparedSizePx = 480;  // px, limit of the longer side of compared pictures, as in stereo
constexpr int kPointsPerView =
    400;                            // tried; their number sets the error, which falls with its root. Guessed.
constexpr int kMostPoints = 40000;  // in all: their number sets the time. Guessed.
constexpr int kViewsPerPoint = 8;   // at most, of those that see it. Guessed.
constexpr int kLightSampleMostAsked = 64;  // views that are tested for visibility of a point. Guessed.
// Darker or brighter light is not compared: it is clipped, or mostly noise. Shares of white. Guessed.
constexpr float kLeastLight = 0.01f, kMostLight = 0.95f;
// Expected difference of the log of light in smooth areas; elsewhere the change by a misalignment of a pixel
// is added. Guessed.
constexpr double kSmoothError = 0.02;

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kHeldOutEvery = 5;  // points

// The level of a photograph whose pixels are compared.
struct SmallPicture {
  cv::Mat pixels;
  double pixel = 1;  // size of a pixel of the level, in px of the view's camera
};

// Log light of B G R at a point of a photograph, and its change over a pixel; none if a channel is clipped,
// nearly black, or missing.
struct LogLight {
  std::array<double, 3> value{}, slope{};
  std::array<bool, 3> counts{};
};
std::optional<LogLight> LogLightAt(const SceneView& view, const SmallPicture& picture, const Vector2d& img) {
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
      light.counts[channel] &= around[i][c] <= kMostLight && above_black >= kLeastLight;
      logs[i] = std::log(std::max(above_black, kLeastLight) * view.scale);
    }
    light.value[channel] = logs[0];
    light.slope[channel] = 0.5 * std::max(std::abs(logs[2] - logs[1]), std::abs(logs[4] - logs[3]));
  }
  return light;
}

// A sharp bend of the proxy's depth about a pixel indicates an edge.
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

// Returns points of the surface that a view sees, spread evenly over its picture.
std::vector<Vector3d> PointsOf(const RenderScene& scene, const SceneView& view, int tries) {
  constexpr int kDepthPx = 240;  // longer side of the depth map
  const CameraModel camera = Within(view.camera.WithoutDistortion(), kDepthPx, 3);
  const auto triangles = scene.proxy->Triangles(camera, view.cam_from_world);
  std::vector<Vector3d> points;
  if (!triangles) return points;
  const cv::Mat inverse_depth = DrawInverseDepth(*triangles, camera, view.cam_from_world);
  const Rigid3 world_from_cam = view.cam_from_world.Inverse();
  // Roberts' sequence is even for any number of points.
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

// Returns a point's light in the views: a sample for each channel in which no view is clipped or nearly
// black. Leaving out single views for that would bias: a limit would cut the bright views of one point and
// the dark ones of the next.
std::vector<LightSample> SamplesOf(const RenderScene& scene, const std::vector<SmallPicture>& pictures,
                                   const std::vector<int>& camera_of, int source, const Vector3d& point,
                                   std::mt19937& random) {
  constexpr double kSeen = 0.999;  // not at an edge of the proxy or the image
  std::array<LightSample, 3> samples;
  std::array<bool, 3> counts{true, true, true};
  std::uniform_int_distribution<int> any(0, static_cast<int>(scene.views.size()) - 1);
  const bool asks_all = static_cast<int>(scene.views.size()) <= kLightSampleMostAsked;
  const int first = any(random);
  std::vector<int> asked;
  for (int i = 0; i < std::min(kLightSampleMostAsked, static_cast<int>(scene.views.size())); ++i) {
    // Takes all in turn from a random one on, or random ones.
    const int index = i == 0     ? source
                      : asks_all ? (first + i) % static_cast<int>(scene.views.size())
                                 : any(random);
    if (std::ranges::count(asked, index) > 0) continue;
    asked.push_back(index);
    const SceneView& view = scene.views[At(index)];
    const auto seen = view.ProjectVisible(point);
    if (!seen || seen->feather < kSeen) continue;
    const auto light = LogLightAt(view, pictures[At(index)], seen->img);
    if (!light) continue;
    const double r2 = (seen->img - Vector2d(view.camera.cx, view.camera.cy)).squaredNorm() /
                      HalfDiagonal(view.camera).squaredNorm();
    for (std::size_t c = 0; c < 3; ++c) {
      counts[c] &= light->counts[c];
      samples[c].seen.push_back(
          {index, camera_of[At(index)], r2, light->value[c], std::hypot(kSmoothError, light->slope[c])});
    }
    if (static_cast<int>(samples[0].seen.size()) == kViewsPerPoint) break;
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

}  // namespace

Eigen::Vector2d HalfDiagonal(const CameraModel& camera) { return {0.5 * camera.width, 0.5 * camera.height}; }

std::vector<LightSample> SampleLight(const RenderScene& scene, const std::vector<int>& camera_of,
                                     std::size_t& points) {
  const std::vector<SmallPicture> pictures = SmallPictures(scene, kComparedSizePx);
  const int tries = std::clamp(kMostPoints / static_cast<int>(scene.views.size()), 1, kPointsPerView);
  std::vector<std::vector<LightSample>> of_views(scene.views.size());
  std::vector<std::size_t> counts(scene.views.size(), 0);
  ParallelFor(scene.views.size(), [&](std::size_t i) {
    std::mt19937 random(static_cast<unsigned>(i + 1));
    for (const Vector3d& point : PointsOf(scene, scene.views[i], tries)) {
      auto samples = SamplesOf(scene, pictures, camera_of, static_cast<int>(i), point, random);
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

}  // namespace ulf::render
