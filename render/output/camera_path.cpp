#include "render/output/camera_path.h"

#include <fmt/format.h>
#include <Eigen/Geometry>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>

#include "core/base/counted.h"
#include "core/base/error.h"
#include "core/base/quantile.h"
#include "core/geometry/angles.h"
#include "render/output/keyframes.h"
#include "render/viewpoints/viewpoint_mesh.h"

namespace ulf::render {
namespace {

// The zoom grows by this factor until the photographs fill the pictures, and not beyond the second: more zoom
// would crop the path's subject. Guessed.
constexpr double kZoomStep = 1.06, kZoomMost = 1.6;
// Share of the pixels that may stay uncovered, in all pictures together and in any one. Guessed.
constexpr double kUncovered = 0.005, kUncoveredAtWorst = 0.02;
constexpr double kBlack = 1e-4;  // share of the pixels of any picture that no view fills: one of a small one
// Pictures of this width are rendered at about this many poses of the path. Guessed.
constexpr int kWidthPx = 120;
constexpr std::size_t kPoses = 12;

using Eigen::Vector3d;

// These thresholds of the named paths are guessed.
constexpr double kWidest = 0.9;      // share of the viewpoints' range that a path uses, at most
constexpr double kShareStep = 0.05;  // decrement of that share until the path is inside the hull
constexpr double kNearPole = 0.95;   // cosine: with the directions' mean nearer to up, up is not used
constexpr double kTogether = 0.3;    // mean length of the directions: a smaller one has no clear middle
constexpr double kOutermost = 0.03;  // share of the views at either end that are outliers of the range
constexpr double kGapOfRing = Radians(75);  // with a larger gap in azimuth, views do not stand all around
constexpr std::size_t kFewestOfRing = 6;    // fewer views do not stand all around

// Azimuth and elevation about `up`, with azimuth from `front`.
struct Sphere {
  Vector3d up, front, left;
  Sphere(const Vector3d& up_in_world, const Vector3d& towards) : up(up_in_world.normalized()) {
    front = towards - towards.dot(up) * up;
    front = front.norm() > 1e-6 ? Vector3d(front.normalized()) : up.unitOrthogonal();
    left = up.cross(front);
  }
  double Azimuth(const Vector3d& d) const { return std::atan2(d.dot(left), d.dot(front)); }
  double Elevation(const Vector3d& d) const { return std::asin(std::clamp(d.dot(up), -1.0, 1.0)); }
  Vector3d Direction(double azimuth, double elevation) const {
    return std::cos(elevation) * (std::cos(azimuth) * front + std::sin(azimuth) * left) +
           std::sin(elevation) * up;
  }
};

double LargestGap(std::vector<double> azimuths) {
  std::ranges::sort(azimuths);
  double gap = 2 * M_PI - (azimuths.back() - azimuths.front());
  for (std::size_t i = 1; i < azimuths.size(); ++i) gap = std::max(gap, azimuths[i] - azimuths[i - 1]);
  return gap;
}

// The distribution of the viewpoints' directions.
struct Spread {
  Sphere sphere;
  double azimuth = 0, elevation = 0;            // middle
  double azimuth_half = 0, elevation_half = 0;  // half the range, without the outermost views
  double ring_elevation = 0;                    // for a path all around
  double distance = 0;
  bool all_around = false;
};

// Near a pole azimuth is undefined: then up is any direction perpendicular to the mean.
Vector3d UsableUp(const RenderScene& scene, const Vector3d& mean) {
  const Vector3d up = scene.up_in_world.normalized();
  return std::abs(up.dot(mean)) < kNearPole ? up : mean.unitOrthogonal();
}

Spread SpreadOf(const RenderScene& scene) {
  std::vector<Vector3d> directions;
  Vector3d sum = Vector3d::Zero();
  for (const SceneView& view : scene.views) {
    if (IsAtCenter(scene.subject, view.center_in_world)) continue;
    directions.push_back((view.center_in_world - scene.subject.center_in_world).normalized());
    sum += directions.back();
  }
  if (directions.empty())
    throw Error("camera path: every view stands at the subject's centre; give another subject with {}",
                Parameter("subject"));
  const double concentration = sum.norm() / static_cast<double>(directions.size());
  const Vector3d mean = concentration > 1e-3 ? Vector3d(sum.normalized()) : directions.front();
  Spread spread{Sphere(concentration > kTogether ? UsableUp(scene, mean) : scene.up_in_world, mean)};
  std::vector<double> azimuths, elevations;
  for (const Vector3d& d : directions) {
    azimuths.push_back(spread.sphere.Azimuth(d));
    elevations.push_back(spread.sphere.Elevation(d));
  }
  spread.distance = scene.mesh.median_distance;  // of the same views
  spread.all_around = directions.size() >= kFewestOfRing && LargestGap(azimuths) < kGapOfRing;
  const auto middle_and_half = [](const std::vector<double>& values, double& middle, double& half) {
    const double low = Quantile(values, kOutermost), high = Quantile(values, 1 - kOutermost);
    middle = 0.5 * (low + high);
    half = 0.5 * (high - low);
  };
  middle_and_half(azimuths, spread.azimuth, spread.azimuth_half);
  middle_and_half(elevations, spread.elevation, spread.elevation_half);
  if (spread.all_around) spread.azimuth = 0;
  spread.ring_elevation = spread.all_around ? Median(elevations) : spread.elevation;
  return spread;
}

Rigid3 AimedPose(const RenderScene& scene, const Vector3d& direction, double distance) {
  const Vector3d& center = scene.subject.center_in_world;
  return LookAt(center + distance * direction, center, scene.up_in_world);
}

CameraPath AimedPath(const RenderScene& scene, const Spread& spread,
                     const std::vector<Vector3d>& directions) {
  CameraPath path;
  for (const Vector3d& direction : directions)
    path.cam_from_world.push_back(AimedPose(scene, direction, spread.distance));
  return path;
}

std::vector<Vector3d> Ellipse(const Spread& spread, int frames, double share) {
  std::vector<Vector3d> directions;
  for (int i = 0; i < frames; ++i) {
    const double phase = 2 * M_PI * i / frames;
    directions.push_back(
        spread.all_around
            ? spread.sphere.Direction(phase, spread.ring_elevation)
            : spread.sphere.Direction(spread.azimuth + share * spread.azimuth_half * std::sin(phase),
                                      spread.elevation + share * spread.elevation_half * std::cos(phase)));
  }
  return directions;
}

// Passes through the middle of the viewpoints' range, by these shares of it at most.
std::vector<Vector3d> ToAndFro(const Spread& spread, int frames, double azimuth_share,
                               double elevation_share) {
  std::vector<Vector3d> directions;
  for (int i = 0; i < frames; ++i) {
    const double off = -std::cos(2 * M_PI * i / std::max(2, frames));
    directions.push_back(
        spread.sphere.Direction(spread.azimuth + azimuth_share * spread.azimuth_half * off,
                                spread.elevation + elevation_share * spread.elevation_half * off));
  }
  return directions;
}

// Returns `directions(share)` for the largest share of the viewpoints' range at which all directions meet the
// mesh.
template <typename Directions>
std::vector<Vector3d> InsideHullOrSmaller(const RenderScene& scene, Directions&& directions) {
  std::vector<Vector3d> tried;
  for (double share = kWidest; share > 0; share -= kShareStep) {
    tried = directions(share);
    if (scene.mesh.span != Span::kSurface ||
        std::ranges::all_of(tried, [&](const Vector3d& d) { return InsideHull(scene.mesh, d); }))
      break;
  }
  return tried;
}

}  // namespace

CameraPath OrbitPath(const RenderScene& scene, int frames) {
  const Spread spread = SpreadOf(scene);
  if (frames <= 1)
    return AimedPath(scene, spread, {spread.sphere.Direction(spread.azimuth, spread.ring_elevation)});
  return AimedPath(
      scene, spread,
      spread.all_around ? Ellipse(spread, frames, kWidest) : InsideHullOrSmaller(scene, [&](double share) {
        return Ellipse(spread, frames, share);
      }));
}

CameraPath DollyPath(const RenderScene& scene, int frames, double nearest_share) {
  const Spread spread = SpreadOf(scene);
  const Vector3d direction = spread.sphere.Direction(spread.azimuth, spread.ring_elevation);
  CameraPath path;
  for (int i = 0; i < frames; ++i) {
    const double along = frames > 1 ? static_cast<double>(i) / (frames - 1) : 1.0;
    // Distances in geometric progression look like a constant zoom.
    path.cam_from_world.push_back(
        AimedPose(scene, direction, spread.distance * std::pow(nearest_share, along)));
  }
  return path;
}

CameraPath VertigoPath(const RenderScene& scene, int frames, const CameraModel& camera,
                       double nearest_share) {
  CameraPath path = DollyPath(scene, frames, nearest_share);
  const auto distance = [&](const Rigid3& pose) {
    return (pose.OriginInSource() - scene.subject.center_in_world).norm();
  };
  const double first = distance(path.cam_from_world.front());
  for (const Rigid3& pose : path.cam_from_world) {
    CameraModel& zoomed = path.cameras.emplace_back(camera);
    zoomed.fx *= distance(pose) / first;
    zoomed.fy *= distance(pose) / first;
  }
  return path;
}

CameraPath SpiralPath(const RenderScene& scene, int frames) {
  constexpr int kTurns = 3;
  const Spread spread = SpreadOf(scene);
  const std::vector<Vector3d> directions = InsideHullOrSmaller(scene, [&](double share) {
    std::vector<Vector3d> tried;
    for (int i = 0; i < frames; ++i) {
      const double along = frames > 1 ? static_cast<double>(i) / frames : 0;
      const double phase = 2 * M_PI * kTurns * along;
      const double out = share * 0.5 * (1 - std::cos(2 * M_PI * along));
      tried.push_back(
          spread.all_around
              ? spread.sphere.Direction(
                    phase, spread.elevation - share * spread.elevation_half * std::cos(2 * M_PI * along))
              : spread.sphere.Direction(spread.azimuth + out * spread.azimuth_half * std::sin(phase),
                                        spread.elevation + out * spread.elevation_half * std::cos(phase)));
    }
    return tried;
  });
  return AimedPath(scene, spread, directions);
}

CameraPath RisePath(const RenderScene& scene, int frames) {
  const Spread spread = SpreadOf(scene);
  return AimedPath(scene, spread, InsideHullOrSmaller(scene, [&](double share) {
                     return ToAndFro(spread, frames, 0, share);
                   }));
}

CameraPath SweepPath(const RenderScene& scene, int frames) {
  const Spread spread = SpreadOf(scene);
  return AimedPath(scene, spread, InsideHullOrSmaller(scene, [&](double share) {
                     return ToAndFro(spread, frames, share, 0);
                   }));
}

CameraPath WalkPath(const RenderScene& scene, int frames) {
  constexpr std::size_t kMostKeyframes = 24;  // a hand's shaking between them is left out. Guessed.
  const std::size_t count = std::min(kMostKeyframes, scene.views.size());
  std::vector<PathKeyframe> keyframes;
  for (std::size_t i = 0; i < count; ++i) {
    const SceneView& view = scene.views[count > 1 ? i * (scene.views.size() - 1) / (count - 1) : 0];
    keyframes.push_back({.time_s = static_cast<double>(i),
                         .eye_in_world = view.center_in_world,
                         .world_from_cam = view.cam_from_world.rotation.conjugate()});
  }
  CameraPath path;
  for (const KeyframedPose& pose : InterpolateKeyframes(keyframes, frames))
    path.cam_from_world.push_back(pose.cam_from_world);
  return path;
}

FillingLens FillingZoom(Renderer& renderer, const CameraPath& path, const CameraModel& camera) {
  const std::size_t poses = path.cam_from_world.size();
  const std::size_t stride = std::max<std::size_t>(1, poses / kPoses);
  double black_at_worst = 0;
  const auto is_filled = [&](double zoom) {
    double sum = 0, worst = 0, count = 0;
    black_at_worst = 0;
    for (std::size_t i = 0; i < poses; i += stride, ++count) {
      const CameraModel& full = path.CameraOf(i, camera);
      CameraModel small = full.ScaledTo(kWidthPx, std::max(1, kWidthPx * full.height / full.width));
      small.fx *= zoom;
      small.fy *= zoom;
      const Rendering picture = renderer.Render(small, path.cam_from_world[i]);
      const auto pixels = static_cast<double>(picture.linear.total());
      const double uncovered = static_cast<double>(picture.empty_px + picture.filled_px) / pixels;
      black_at_worst = std::max(black_at_worst, static_cast<double>(picture.empty_px) / pixels);
      sum += uncovered;
      worst = std::max(worst, uncovered);
    }
    return sum <= kUncovered * count && worst <= kUncoveredAtWorst;
  };
  std::optional<FillingLens> almost;
  for (double zoom = 1;; zoom *= kZoomStep) {
    const bool is_almost_filled = is_filled(zoom);
    const FillingLens filling{zoom, black_at_worst};
    if (is_almost_filled && black_at_worst <= kBlack) return {zoom, 0};
    if (is_almost_filled && !almost) almost = filling;
    if (zoom * kZoomStep > kZoomMost) return almost.value_or(filling);
  }
}

bool IsNamedPath(const std::string& path) {
  return path == "orbit" || path == "dolly" || path == "vertigo" || path == "spiral" || path == "rise" ||
         path == "sweep" || path == "walk";
}

void RequireFrames(const CameraPath& path, int asked, const std::string& frames) {
  const std::size_t poses = path.cam_from_world.size();
  if (asked > 0 && static_cast<std::size_t>(asked) != poses)
    throw Refusal(
        Parameter("frames"), frames,
        fmt::format("the path has {}, one for each picture", Counted(poses, "pose")),
        "only named paths and keyframes take another number. Leave the number out, or give a part, A:B");
}

namespace {

int Number(std::string_view digits, const std::string& text, int least) {
  int number = -1;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
  if (error != std::errc() || end != digits.data() + digits.size() || number < least)
    throw Refusal(Parameter("frames"), text,
                  "give N pictures, or A:B for pictures A to B - 1 of the path, or A:B/N", "");
  return number;
}

}  // namespace

FrameRange ParseFrames(const std::string& text) {
  FrameRange range;
  if (text.empty()) return range;
  std::string_view rest = text;
  const auto colon = rest.find(':'), slash = rest.find('/');
  if (colon == std::string_view::npos) {
    range.count = Number(rest, text, 1);
    return range;
  }
  if (slash != std::string_view::npos) {
    range.count = Number(rest.substr(slash + 1), text, 1);
    rest = rest.substr(0, slash);
  }
  const std::string_view first = rest.substr(0, colon),
                         end = colon < rest.size() ? rest.substr(colon + 1) : std::string_view();
  if (!first.empty()) range.first = Number(first, text, 0);
  if (!end.empty()) range.end = Number(end, text, 0);
  if (range.end && *range.end <= range.first)
    throw Refusal(Parameter("frames"), text,
                  fmt::format("picture {} does not come before {}", range.first, *range.end),
                  "A:B are pictures A to B - 1");
  return range;
}

}  // namespace ulf::render
