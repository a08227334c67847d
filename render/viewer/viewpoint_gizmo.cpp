#include "render/viewer/viewpoint_gizmo.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/base/at.h"
#include "core/base/quantile.h"
#include "render/viewer/viewer_camera.h"
#include "render/viewpoints/viewpoint_mesh.h"

namespace ulf::render {
namespace {

// The sphere is seen from this much above if more than this share of the views stand on its far side.
// Guessed.
constexpr double kFromAboveRad = Radians(20), kFarShare = 0.25;
// For views of a row or a ring, a camera farther from all of them than this many median spacings, and this
// angle, is outside. Guessed.
constexpr double kOutsideSpacings = 2, kOutsideRad = Radians(1);
// A camera is too near or too far when it leaves the views' distances by more than this factor. Guessed.
constexpr double kDistanceMargin = 1.02;

using Eigen::Vector2d;
using Eigen::Vector3d;

const Rgba kSphere{40, 42, 48, 200}, kRim{235, 235, 235, 160};
const Rgba kCovered{70, 190, 90, 150}, kCoveredBehind{70, 190, 90, 60};
const Rgba kView{255, 255, 255, 220}, kViewBehind{255, 255, 255, 70};
const Rgba kCamera{235, 30, 40}, kCameraRim{255, 255, 255};

constexpr double kRadius = 0.46;  // of the sphere, in sizes of the picture

// Returns the median over the views of the angle to the nearest other view; for many views of a sample.
double MedianSpacing(const std::vector<Vector3d>& directions) {
  if (directions.size() < 2) return 0;
  constexpr std::size_t kSample = 100;
  const std::size_t stride = std::max<std::size_t>(1, directions.size() / kSample);
  std::vector<double> least;
  for (std::size_t i = 0; i < directions.size(); i += stride) {
    double nearest = M_PI;
    for (std::size_t j = 0; j < directions.size(); ++j)
      if (j != i) nearest = std::min(nearest, AngleBetween(directions[i], directions[j]));
    least.push_back(nearest);
  }
  return Median(least);
}

std::vector<Vector2d> Circle(const Vector2d& middle, double radius) {
  constexpr int kCorners = 48;
  std::vector<Vector2d> circle;
  for (int i = 0; i < kCorners; ++i) {
    const double phase = 2 * M_PI * i / kCorners;
    circle.push_back(middle + radius * Vector2d(std::cos(phase), std::sin(phase)));
  }
  return circle;
}

Patch Square(const Vector2d& middle, double half, const Rgba& color) {
  return {{middle + Vector2d(-half, -half), middle + Vector2d(half, -half), middle + Vector2d(half, half),
           middle + Vector2d(-half, half)},
          color};
}

}  // namespace

ViewpointGizmo::ViewpointGizmo(const RenderScene& scene)
    : subject_(scene.subject), has_subject_(scene.has_subject), mesh_(scene.mesh) {
  const ViewerCamera start = StartingCamera(scene);
  Rigid3 look = start.CamFromWorld();
  std::vector<double> distances;
  int behind = 0;
  for (const SceneView& view : scene.views) {
    const Vector3d arm = view.center_in_world - subject_.center_in_world;
    if (IsAtCenter(subject_, view.center_in_world)) continue;
    distances.push_back(arm.norm());
    directions_.push_back(arm.normalized());
    behind += arm.dot(start.eye_in_world - start.target_in_world) < 0;
  }
  if (behind > kFarShare * static_cast<double>(directions_.size()))
    look = Orbited(start, 0, kFromAboveRad).CamFromWorld();
  right_ = look.DirectionInSource(Vector3d::UnitX());
  up_ = look.DirectionInSource(-Vector3d::UnitY());
  towards_ = look.DirectionInSource(-Vector3d::UnitZ());
  nearest_ = *std::ranges::min_element(distances);
  farthest_ = *std::ranges::max_element(distances);
  spacing_rad_ = MedianSpacing(directions_);
}

ViewpointGizmo::Place ViewpointGizmo::PlaceOf(const Vector3d& direction, double size) const {
  const Vector3d unit = direction.normalized();
  return {size * (Vector2d(0.5, 0.5) + kRadius * Vector2d(unit.dot(right_), -unit.dot(up_))),
          unit.dot(towards_) >= 0};
}

Overlay ViewpointGizmo::Draw(const Vector3d& eye, double size) const {
  Overlay behind, before;
  for (const Triangle& t : mesh_.triangles) {
    std::array<Vector2d, 3> img;
    int in_front = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto& vertex = mesh_.vertices[At(t[k])];
      const Place place = PlaceOf(vertex.position_in_world - subject_.center_in_world, size);
      img[k] = place.img;
      in_front += place.front;
    }
    const bool front = in_front >= 2;
    (front ? before : behind)
        .emplace_back(Patch{{img[0], img[1], img[2], img[2]}, front ? kCovered : kCoveredBehind});
  }
  for (const Vector3d& direction : directions_) {
    const Place place = PlaceOf(direction, size);
    (place.front ? before : behind).emplace_back(Square(place.img, 1, place.front ? kView : kViewBehind));
  }
  Overlay all{Polygon{Circle({0.5 * size, 0.5 * size}, kRadius * size), kSphere}};
  all.insert(all.end(), behind.begin(), behind.end());
  all.insert(all.end(), before.begin(), before.end());
  all.emplace_back(Polyline{Circle({0.5 * size, 0.5 * size}, kRadius * size), 1.5, kRim, true});
  const Place camera = PlaceOf(eye - subject_.center_in_world, size);
  if (camera.front) {
    all.emplace_back(Spot{camera.img, 6, kCameraRim});
    all.emplace_back(Spot{camera.img, 4.5, kCamera});
  } else {
    all.emplace_back(Polyline{Circle(camera.img, 5), 2, kCamera, true});
  }
  return all;
}

double ViewpointGizmo::Spacing() const {
  constexpr double kLeastShare = 1e-3;  // of the distance, for views that share a centre
  return std::max(spacing_rad_, kLeastShare) * std::max(farthest_, subject_.radius);
}

bool ViewpointGizmo::IsOutside(const Vector3d& direction) const {
  if (mesh_.span == Span::kSurface) return !InsideHull(mesh_, direction);
  const double allowed = std::max(kOutsideRad, kOutsideSpacings * spacing_rad_);
  return std::ranges::none_of(directions_,
                              [&](const Vector3d& view) { return AngleBetween(view, direction) <= allowed; });
}

std::string ViewpointGizmo::Warning(const Vector3d& eye) const {
  if (!has_subject_) return {};
  const Vector3d arm = eye - subject_.center_in_world;
  const double distance = arm.norm();
  if (distance < subject_.radius) return "inside the subject's sphere";
  std::string warning;
  const auto add = [&](const std::string& words) { warning += (warning.empty() ? "" : "; ") + words; };
  if (IsOutside(arm)) add("outside the recorded views: the nearest ones are stretched");
  if (distance * kDistanceMargin < nearest_)
    add(fmt::format("{:.1f} times nearer than any view", nearest_ / distance));
  if (distance > farthest_ * kDistanceMargin)
    add(fmt::format("{:.1f} times farther than any view", distance / farthest_));
  return warning;
}

}  // namespace ulf::render
