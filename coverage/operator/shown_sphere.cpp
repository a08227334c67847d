#include "coverage/operator/shown_sphere.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "core/geometry/angles.h"
#include "coverage/bound/criterion.h"
#include "coverage/operator/palette.h"

namespace ulf::coverage {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// The map's painted cells; neighbours that one view paints are one patch.
void AddPaint(const CoverageMap& map, double distance, ShownSphere& sphere) {
  const DistanceColors colors(map, distance, Palette::Standard());
  std::vector<double> nearer;
  for (const CriterionView& view : map.views()) nearer.push_back(colors.Nearer(view));
  constexpr double kWidest = Radians(5);
  for (const CoverageMap::PaintedRun& run : map.PaintedRuns(kWidest)) {
    const CapFrame& frame = sphere.frame;
    const std::array corners{frame.Direction(run.left, run.bottom), frame.Direction(run.right, run.bottom),
                             frame.Direction(run.right, run.top), frame.Direction(run.left, run.top)};
    if (std::ranges::all_of(corners, [&](const Vector3d& at) { return sphere.Faces(at); }))
      sphere.paint.push_back(
          {run.left, run.right, run.bottom, run.top, nearer[static_cast<std::size_t>(run.view)]});
  }
}

// A view's rim encloses what it covers. Rims are shown only near the present camera, where they tell how far
// to go: all rims of a full map would hide the map.
void AddViews(const CoverageMap& map, const Eigen::Matrix3d& cam_from_world, ShownSphere& sphere) {
  constexpr double kRimReach = 2.5;  // disc radii
  const double usual_radius = map.spacing() * map.options().cells_per_disc_radius;
  // Radii by distance and threshold, computed once for those that differ by less than 1 %.
  std::map<std::pair<long, long>, double> radius_of;
  for (const CriterionView& view : map.views()) {
    const Vector3d offset = cam_from_world * (view.center_in_world - map.subject().center_in_world);
    ShownSphere::View shown{offset.normalized()};
    if (!sphere.Faces(shown.direction)) continue;
    if (sphere.AngleFromDot(shown.direction) <= kRimReach * usual_radius) {
      const double threshold_px =
          map.ThresholdAt((view.center_in_world - map.subject().center_in_world).normalized());
      const std::pair step(std::lround(100 * std::log(offset.norm())),
                           std::lround(100 * std::log(threshold_px)));
      const auto [found, is_new] = radius_of.try_emplace(step, 0.0);
      if (is_new)
        found->second = DiscRadius({.focal_px = view.fx,
                                    .distance = offset.norm(),
                                    .radius = map.subject().radius,
                                    .threshold_px = threshold_px},
                                   map.reference_distance() / offset.norm())
                            .value_or(0);
      if (found->second < M_PI / 2) shown.rim = found->second;
    }
    sphere.views.push_back(shown);
  }
}

void AddErrors(const CaptureState& state, const Eigen::Matrix3d& cam_from_world, ShownSphere& sphere) {
  for (const ErrorMap::Part* part : state.errors->Parts()) {
    const MeasuredFrame& frame = part->frame;
    if (!frame.measurable && frame.cause != render::ErrorCause::kNotSeen) continue;
    const Vector3d direction = cam_from_world * frame.direction;
    if (!sphere.Faces(direction)) continue;
    ShownSphere::Error error{direction, part->DbNow() - state.cover.db, frame.cause, false};
    if (!frame.measurable) error.db_above_goal = -Palette::kErrorReach_db;
    const auto at = state.coverage && !state.coverage->views().empty() ? state.coverage->At(frame.direction)
                                                                       : std::nullopt;
    error.marked = error.db_above_goal < 0 && at && at->index >= 0;
    sphere.errors.push_back(error);
  }
}

std::vector<Vector3d> Facing(const ShownSphere& sphere, const Eigen::Matrix3d& cam_from_world,
                             const std::vector<Vector3d>& directions) {
  std::vector<Vector3d> facing;
  for (const Vector3d& direction : directions)
    if (const Vector3d in_cam = cam_from_world * direction; sphere.Faces(in_cam)) facing.push_back(in_cam);
  return facing;
}

}  // namespace

Vector3d ShownSphere::Along(const Vector3d& direction, double angle) const {
  const Vector3d sideways = direction - direction.dot(toward_camera) * toward_camera;
  if (sideways.norm() < 1e-9) return toward_camera;
  return std::cos(angle) * toward_camera + std::sin(angle) * sideways.normalized();
}

double ShownSphere::AngleFromDot(const Vector3d& direction) const {
  return AngleBetween(direction, toward_camera);
}

std::optional<ShownSphere> ShownSphere::Of(const CaptureState& state, double reach) {
  if (!state.cam_from_world || !state.subject) return std::nullopt;
  const Vector3d center = *state.cam_from_world * state.subject->center_in_world;
  const double distance = center.norm(), radius = state.subject->radius;
  if (!(distance > radius)) return std::nullopt;
  const Eigen::Matrix3d cam_from_world = state.cam_from_world->rotation.toRotationMatrix();
  const Vector3d toward_camera = -center / distance;
  const CoverageMap* map =
      state.coverage && !state.coverage->views().empty() ? state.coverage.get() : nullptr;
  const CapFrame frame =
      map ? CapFrame(cam_from_world * map->frame()->Direction(0, 0), cam_from_world * map->frame()->Up())
          : CapFrame(toward_camera, -Vector3d::UnitY());
  const double limb = std::min(reach, std::acos(radius / distance));
  ShownSphere sphere{.radius = radius / distance,
                     .toward_camera = toward_camera,
                     .least_cosine = std::cos(limb),
                     .frame = frame,
                     .cap = map ? map->options().cap : std::nullopt,
                     .paint = {},
                     .views = {},
                     .reopened = {},
                     .left_open = {},
                     .errors = {},
                     .target = {}};
  if (map) {
    AddPaint(*map, distance, sphere);
    AddViews(*map, cam_from_world, sphere);
  }
  if (state.errors) AddErrors(state, cam_from_world, sphere);
  sphere.reopened = Facing(sphere, cam_from_world, state.reopened);
  sphere.left_open = Facing(sphere, cam_from_world, state.guidance.left_open);
  if (const auto& toward = state.guidance.toward) {
    const double radius_shown = state.guidance.disc_radius;
    Target target{.direction = cam_from_world * *toward,
                  .ring = radius_shown > 0 ? std::min(radius_shown, 0.5) : Radians(3)};
    target.hidden = !sphere.Faces(target.direction);
    if (target.hidden) target.direction = sphere.Along(target.direction, limb);
    sphere.target = target;
  }
  return sphere;
}

std::optional<bool> IsSubjectInRectangle(const CaptureState& state) {
  if (!state.cam_from_world || !state.subject) return std::nullopt;
  const auto outline = SphereOutline(state.camera, *state.cam_from_world, *state.subject);
  return outline && SafetyRectangle::Of(state.camera).Holds(*outline);
}

ShownPicture ShownPicture::Of(const CaptureState& state) {
  ShownPicture shown;
  shown.camera = state.camera;
  if (!state.cam_from_world) return shown;
  shown.rectangle = SafetyRectangle::Of(state.camera);
  shown.held = IsSubjectInRectangle(state).value_or(true);
  shown.sphere = ShownSphere::Of(state);
  if (shown.held) return shown;
  const Vector3d center_in_cam = *state.cam_from_world * state.subject->center_in_world;
  const auto img = state.camera.ImgFromCam(center_in_cam);
  const Vector2d &low = shown.rectangle->low, &high = shown.rectangle->high;
  if (img && shown.rectangle->Holds({*img})) return shown;
  const Vector2d toward = img ? Vector2d(*img - 0.5 * (low + high)) : Vector2d(center_in_cam.head<2>());
  // A subject straight behind can be reached by turning either way.
  shown.way_to_subject = toward.norm() > 1e-9 ? Vector2d(toward.normalized()) : Vector2d(1, 0);
  return shown;
}

}  // namespace ulf::coverage
