#include "coverage/operator/overlay.h"

#include <fmt/core.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>

#include "coverage/sphere_outline.h"

namespace ulf {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kDegree = M_PI / 180;
const Rgba kWhite{255, 255, 255}, kShade{0, 0, 0, 190};

// The sphere before the camera: directions from its centre to the picture.
struct Sphere {
  const CameraModel& camera;
  const Rigid3& cam_from_world;
  const Subject& subject;
  Vector3d toward_camera = Vector3d::Zero();  // unit, from the centre
  double distance = 0;
  double least_cosine = -1;  // of directions that are drawn, to the camera's own

  // `reach`: nothing farther from the camera's own direction is drawn, radians.
  Sphere(const CameraModel& of_camera, const Rigid3& pose, const Subject& of_subject, double reach = M_PI)
      : camera(of_camera), cam_from_world(pose), subject(of_subject) {
    const Vector3d offset = pose.OriginInSource() - subject.center_in_world;
    distance = offset.norm();
    toward_camera = offset / distance;
    least_cosine = std::max(std::cos(reach), subject.radius / distance);
  }
  // The near side shows a direction when its surface point faces the camera.
  bool Faces(const Vector3d& direction) const { return direction.dot(toward_camera) > least_cosine; }
  std::optional<Vector2d> ImgOf(const Vector3d& direction) const {
    return camera.ImgFromCam(cam_from_world * (subject.center_in_world + subject.radius * direction));
  }
  std::optional<Vector2d> ImgOfFacing(const Vector3d& direction) const {
    return Faces(direction) ? ImgOf(direction) : std::nullopt;
  }
  // Away from the camera's own direction along the sphere, `angle` towards `direction`.
  Vector3d Along(const Vector3d& from, const Vector3d& direction, double angle) const {
    const Vector3d sideways = direction - direction.dot(from) * from;
    if (sideways.norm() < 1e-9) return from;
    return std::cos(angle) * from + std::sin(angle) * sideways.normalized();
  }
};

// A curve over the sphere, t from 0 to 1: the parts that face the camera.
template <typename DirectionAt>
void AddCurve(const Sphere& sphere, const DirectionAt& direction_at, int steps, double width,
              const Rgba& color, Overlay& overlay) {
  Polyline part{.img = {}, .width = width, .color = color};
  const auto end_part = [&] {
    if (part.img.size() > 1) overlay.push_back(part);
    part.img.clear();
  };
  for (int i = 0; i <= steps; ++i) {
    const auto img = sphere.ImgOfFacing(direction_at(static_cast<double>(i) / steps));
    if (img)
      part.img.push_back(*img);
    else
      end_part();
  }
  end_part();
}

void AddCircle(const Sphere& sphere, const Vector3d& around, double radius, double width, const Rgba& color,
               Overlay& overlay) {
  const Vector3d x = around.unitOrthogonal(), y = around.cross(x);
  const auto at = [&](double t) -> Vector3d {
    const double turn = 2 * M_PI * t;
    return std::cos(radius) * around + std::sin(radius) * (std::cos(turn) * x + std::sin(turn) * y);
  };
  AddCurve(sphere, at, 32, width, color, overlay);
}

void AddWireframe(const Sphere& sphere, const CapFrame& frame, const Rgba& color, Overlay& overlay) {
  constexpr int kSpacingDeg = 10;
  for (int deg = -180; deg < 180; deg += kSpacingDeg)
    AddCurve(
        sphere, [&](double t) { return frame.Direction(deg * kDegree, (t - 0.5) * M_PI); }, 45, 1, color,
        overlay);
  for (int deg = -80; deg <= 80; deg += kSpacingDeg)
    AddCurve(
        sphere, [&](double t) { return frame.Direction((2 * t - 1) * M_PI, deg * kDegree); }, 90, 1, color,
        overlay);
}

// The map's own cells, neighbours of one view in one patch.
void AddPaint(const Sphere& sphere, const CoverageMap& map, const Palette& palette, Overlay& overlay) {
  const DistanceColors colors(map, sphere.distance, palette);
  std::vector<Rgba> color_of_view;
  for (const CriterionView& view : map.views()) color_of_view.push_back(colors.Of(view).WithOpacity(0.72));
  constexpr double kWidest = 5 * kDegree;
  const CapFrame& frame = *map.frame();
  for (const CoverageMap::PaintedRun& run : map.PaintedRuns(kWidest)) {
    const std::array directions{frame.Direction(run.left, run.bottom), frame.Direction(run.right, run.bottom),
                                frame.Direction(run.right, run.top), frame.Direction(run.left, run.top)};
    Patch patch{.img = {}, .color = color_of_view[static_cast<std::size_t>(run.view)]};
    bool whole = true;
    for (std::size_t i = 0; i < directions.size() && whole; ++i) {
      const auto img = sphere.ImgOfFacing(directions[i]);
      whole = img.has_value();
      if (whole) patch.img[i] = *img;
    }
    if (whole) overlay.push_back(patch);
  }
}

// Each recorded view is a disc of what it covers; its rim is drawn near the present camera, where the rims
// tell how far to go on. All rims of a full map would hide it.
void AddViews(const Sphere& sphere, const CoverageMap& map, Overlay& overlay) {
  constexpr double kRimReach = 2.5;  // disc radii
  const Rgba rim{10, 10, 10, 150}, middle{10, 10, 10, 210};
  const double usual_radius = map.spacing() * map.options().cells_per_disc_radius;
  std::map<long, double> radius_of_distance;  // views lie at much the same distances
  for (const CriterionView& view : map.views()) {
    const Vector3d offset = view.center_in_world - sphere.subject.center_in_world;
    const Vector3d direction = offset.normalized();
    const auto img = sphere.ImgOfFacing(direction);
    if (!img) continue;
    overlay.push_back(Spot{*img, 1.6, middle});
    const double away = std::acos(std::clamp(direction.dot(sphere.toward_camera), -1.0, 1.0));
    if (away > kRimReach * usual_radius) continue;
    const long step = std::lround(100 * std::log(offset.norm()));
    const auto [found, is_new] = radius_of_distance.try_emplace(step, 0.0);
    if (is_new)
      found->second = DiscRadius({.focal_px = view.fx,
                                  .distance = offset.norm(),
                                  .radius = sphere.subject.radius,
                                  .threshold_px = map.options().threshold_px},
                                 map.reference_distance() / offset.norm())
                          .value_or(0);
    if (found->second > 0 && found->second < M_PI / 2)
      AddCircle(sphere, direction, found->second, 1.2, rim, overlay);
  }
}

void AddCapOutline(const Sphere& sphere, const CapFrame& frame, const Cap& cap, Overlay& overlay) {
  const double x = 0.5 * cap.width, y = 0.5 * cap.height;
  for (const auto& [width, color] : {std::pair{5.0, kShade}, std::pair{2.5, kWhite}})
    for (const double side : {-1.0, 1.0}) {
      AddCurve(
          sphere, [&](double t) { return frame.Direction(side * x, (2 * t - 1) * y); }, 60, width, color,
          overlay);
      AddCurve(
          sphere, [&](double t) { return frame.Direction((2 * t - 1) * x, side * y); }, 60, width, color,
          overlay);
    }
}

// Small marks on directions, with a dark rim that holds on any colour.
void AddMarks(const Sphere& sphere, const std::vector<Vector3d>& directions, double radius, const Rgba& color,
              Overlay& overlay) {
  for (const Vector3d& direction : directions) {
    const auto img = sphere.ImgOfFacing(direction);
    if (!img) continue;
    overlay.push_back(Spot{*img, radius + 1, kWhite.WithOpacity(0.8)});
    overlay.push_back(Spot{*img, radius, color});
  }
}

void AddArrow(const std::vector<Vector2d>& img, double width, double head, const Rgba& color,
              Overlay& overlay) {
  const Vector2d tip = img.back();
  // The head's direction is that of the last stretch as long as the head.
  Vector2d from = img.front();
  for (auto point = img.rbegin(); point != img.rend(); ++point)
    if ((*point - tip).norm() > 0.7 * head) {
      from = *point;
      break;
    }
  if ((tip - from).norm() < 1e-6) return;
  const Vector2d ahead = (tip - from).normalized(), side(-ahead.y(), ahead.x());
  std::vector<Vector2d> shaft;
  for (const Vector2d& point : img)
    if ((point - tip).norm() > 0.8 * head) shaft.push_back(point);
  const auto head_of = [&](double grow) {
    return std::vector<Vector2d>{tip + grow * ahead,
                                 tip - (head + 0.5 * grow) * ahead + (0.5 * head + grow) * side,
                                 tip - (head + 0.5 * grow) * ahead - (0.5 * head + grow) * side};
  };
  if (shaft.size() > 1) {
    shaft.push_back(tip - 0.75 * head * ahead);
    overlay.push_back(Polyline{shaft, width + 3, kShade});
  }
  overlay.push_back(Polygon{head_of(0.15 * head), kShade});
  if (shaft.size() > 1) overlay.push_back(Polyline{shaft, width, color});
  overlay.push_back(Polygon{head_of(0), color});
}

// From the red dot over the sphere to where the next view belongs.
void AddGuidance(const Sphere& sphere, const Guidance& guidance, const Palette& palette, Overlay& overlay) {
  AddMarks(sphere, guidance.left_open, 2.2, palette.guide, overlay);
  if (!guidance.toward) return;
  const Vector3d& target = *guidance.toward;
  const double ring = guidance.disc_radius > 0 ? std::min(guidance.disc_radius, 0.5) : 3 * kDegree;
  AddCircle(sphere, target, ring, 6, kShade, overlay);
  AddCircle(sphere, target, ring, 3, palette.guide, overlay);
  const double away = std::acos(std::clamp(target.dot(sphere.toward_camera), -1.0, 1.0));
  if (away < 1.2 * ring) return;
  // Up to the ring, which stays free; a target round the corner is pointed at from the limb.
  const double limb = std::acos(sphere.subject.radius / sphere.distance);
  const double end = std::min(away - 0.9 * ring, 0.97 * limb);
  std::vector<Vector2d> way;
  constexpr int kSteps = 24;
  for (int i = 0; i <= kSteps; ++i)
    if (const auto img = sphere.ImgOf(sphere.Along(sphere.toward_camera, target, end * i / kSteps)))
      way.push_back(*img);
  if (way.size() > 1)
    AddArrow(way, 5, std::clamp(0.45 * (way.back() - way.front()).norm(), 8.0, 0.03 * sphere.camera.width),
             palette.guide, overlay);
}

void AddPresentCamera(const Sphere& sphere, const Palette& palette, Overlay& overlay) {
  const auto img = sphere.ImgOf(sphere.toward_camera);
  if (!img) return;
  overlay.push_back(Spot{*img, 8, {0, 0, 0, 120}});
  overlay.push_back(Spot{*img, 7, kWhite});
  overlay.push_back(Spot{*img, 5, palette.camera});
}

// Towards a subject that the picture does not show: where it would enter.
void AddWayToSubject(const CaptureState& state, const SafetyRectangle& rectangle, const Palette& palette,
                     Overlay& overlay) {
  const Vector3d center_in_cam = *state.cam_from_world * state.subject->center_in_world;
  const auto img = state.camera.ImgFromCam(center_in_cam);
  const bool in_rectangle =
      img && (img->array() >= rectangle.low.array()).all() && (img->array() <= rectangle.high.array()).all();
  if (in_rectangle) return;
  const Vector2d middle = 0.5 * (rectangle.low + rectangle.high),
                 half = 0.5 * (rectangle.high - rectangle.low);
  Vector2d toward = img ? Vector2d(*img - middle) : Vector2d(center_in_cam.head<2>());
  // Straight behind: any way is as good.
  toward = toward.norm() > 1e-9 ? toward.normalized() : Vector2d(1, 0);
  const double to_border = 1 / (toward.cwiseAbs().cwiseQuotient(half)).maxCoeff();
  const Vector2d tip = middle + 0.94 * to_border * toward;
  const double length = 0.3 * half.y();
  std::vector<Vector2d> way;
  for (int i = 0; i <= 8; ++i) way.push_back(tip - length * (1 - i / 8.0) * toward);
  AddArrow(way, 12, 0.45 * length, palette.alarm, overlay);
  overlay.push_back(
      Label{.img = tip - 1.35 * length * toward, .text = "subject", .size = 22, .color = kWhite});
}

void AddRectangle(const SafetyRectangle& rectangle, bool held, const Palette& palette, Overlay& overlay) {
  const Vector2d low = rectangle.low, high = rectangle.high;
  const std::vector<Vector2d> corners{low, {high.x(), low.y()}, high, {low.x(), high.y()}};
  overlay.push_back(Polyline{corners, held ? 4.0 : 9.0, {0, 0, 0, 110}, true});
  overlay.push_back(Polyline{corners, held ? 2.0 : 6.0, held ? kWhite : palette.alarm, true});
  if (!held)
    overlay.push_back(Label{.img = {0.5 * (low.x() + high.x()), low.y()},
                            .text = "OUTSIDE",
                            .size = 30,
                            .color = palette.alarm,
                            .anchor = {0.5, -0.3}});
}

void AddOutline(const Sphere& sphere, double width, const Rgba& color, const Rgba& fill, Overlay& overlay) {
  const auto outline = SphereOutline(sphere.camera, sphere.cam_from_world, sphere.subject, 96);
  if (!outline) return;
  if (fill.a > 0) overlay.push_back(Polygon{*outline, fill});
  overlay.push_back(Polyline{*outline, width, color, true});
}

// All that hangs on the sphere of a subject, from outside it.
void AddSphere(const CaptureState& state, const Palette& palette, Overlay& overlay, double reach = M_PI) {
  const Sphere sphere(state.camera, *state.cam_from_world, *state.subject, reach);
  if (sphere.distance <= state.subject->radius) return;
  // Dark where nothing covers: recognisable before any colour is.
  AddOutline(sphere, 1.5, kWhite.WithOpacity(0.8), {25, 25, 30, 110}, overlay);
  const bool painted = state.coverage && !state.coverage->views().empty();
  if (painted) AddPaint(sphere, *state.coverage, palette, overlay);
  const CapFrame frame =
      painted ? *state.coverage->frame()
              : CapFrame(sphere.toward_camera, sphere.cam_from_world.DirectionInSource(-Vector3d::UnitY()));
  AddWireframe(sphere, frame, kWhite.WithOpacity(0.4), overlay);
  if (painted) {
    AddViews(sphere, *state.coverage, overlay);
    if (const auto& cap = state.coverage->options().cap) AddCapOutline(sphere, frame, *cap, overlay);
  }
  AddMarks(sphere, state.reopened, 3, palette.reopened, overlay);
  AddGuidance(sphere, state.guidance, palette, overlay);
  AddPresentCamera(sphere, palette, overlay);
}

std::string Percent(double ratio) { return fmt::format("{:.0f} %", 100 * std::abs(ratio - 1)); }

}  // namespace

std::optional<bool> SubjectIsHeld(const CaptureState& state) {
  if (!state.cam_from_world || !state.subject) return std::nullopt;
  const auto outline = SphereOutline(state.camera, *state.cam_from_world, *state.subject);
  return outline && SafetyRectangle::Of(state.camera, state.rectangle_share).Holds(*outline);
}

Overlay SphereOverlay(const CameraModel& camera, const Rigid3& cam_from_world, const Subject& subject,
                      const Rgba& color) {
  Overlay overlay;
  const Sphere sphere(camera, cam_from_world, subject);
  if (sphere.distance <= subject.radius) return overlay;
  AddWireframe(sphere, CapFrame(sphere.toward_camera, cam_from_world.DirectionInSource(-Vector3d::UnitY())),
               color.WithOpacity(0.6), overlay);
  AddOutline(sphere, 2, color, {0, 0, 0, 0}, overlay);
  return overlay;
}

Overlay MakeOverlay(const CaptureState& state, const Palette& palette) {
  Overlay overlay;
  if (!state.cam_from_world) return overlay;
  const SafetyRectangle rectangle = SafetyRectangle::Of(state.camera, state.rectangle_share);
  const bool held = SubjectIsHeld(state).value_or(true);
  if (state.subject) AddSphere(state, palette, overlay);
  AddRectangle(rectangle, held, palette, overlay);
  if (!held) AddWayToSubject(state, rectangle, palette, overlay);
  return overlay;
}

std::optional<CloseLook> MakeCloseLook(const CaptureState& state, int width, int height,
                                       const Palette& palette) {
  if (!state.cam_from_world || !state.subject || !state.coverage || state.coverage->views().empty())
    return std::nullopt;
  const CoverageMap& map = *state.coverage;
  const Vector3d center_in_cam = *state.cam_from_world * state.subject->center_in_world;
  const double to_surface = center_in_cam.norm() - state.subject->radius;
  if (!(to_surface > 0)) return std::nullopt;
  // So far that one view's disc is well seen and its neighbours are, too.
  constexpr double kDiscShare = 0.11;  // its radius, of the height
  const double disc_radius = map.spacing() * map.options().cells_per_disc_radius;
  const double focal_px = kDiscShare * height * to_surface / (state.subject->radius * disc_radius);
  CaptureState close = state;
  close.camera = CameraModel::Pinhole(width, height, focal_px);
  // Turned onto the subject, with the live picture's own roll: what moves left there moves left here.
  const auto aimed = Eigen::Quaterniond::FromTwoVectors(center_in_cam, Vector3d::UnitZ());
  close.cam_from_world = Rigid3{aimed, Vector3d::Zero()} * *state.cam_from_world;
  CloseLook look{.size = {width, height}, .shapes = {}};
  // What lies beyond the picture's corners is left out before it costs anything.
  const double corner = 0.5 * std::hypot(width, height) / (kDiscShare * height) * disc_radius;
  AddSphere(close, palette, look.shapes, std::min(M_PI, 1.5 * corner + 0.1));
  return look;
}

Instruction InstructionFor(const CaptureState& state) {
  constexpr double kFarOff = 1.05, kRowFarOff = 1.2, kRowNarrow = 0.5;
  if (!state.waiting_for.empty() && !state.device_problem.empty()) return {state.device_problem, true};
  if (!state.cam_from_world) {
    if (!state.tracking_words.empty()) return {state.tracking_words, true};
    return {state.tracking == TrackState::kLost ? "go back to where the camera was before"
                                                : "move the camera sideways",
            true};
  }
  if (!state.subject) return {"centre the subject in the picture", true};
  if (state.subject_moved) return {"the subject has moved: put it back, or place it anew (S)", true};
  switch (state.decision.reason) {
    case Reason::kOutsideRectangle:
      return {"bring the sphere back into the rectangle", true};
    case Reason::kBehind:
      return {"the subject is behind the camera: turn round", true};
    case Reason::kInsideSphere:
      return {"too near: go back from the subject", true};
    default:
      break;
  }
  if (!state.recording) return {"paused: Space goes on", true};
  switch (state.decision.reason) {
    case Reason::kSpeed:
      return {"too fast: slower", true};
    case Reason::kBlur:
      return {"blurred: hold still", true};
    case Reason::kExposure:
      return {"the subject is too bright or too dark: set the exposure", true};
    case Reason::kUnsettled:
      return {"the exposure is still settling: wait, or lock it", true};
    case Reason::kSpool:
      return {"the disk is behind: wait", true};
    case Reason::kDisk:
      return {"the disk is full: make room, recording then goes on", true};
    case Reason::kTracking:
      return {"tracking is poor: show more of what was seen before", true};
    default:
      break;
  }
  const double now = (state.cam_from_world->OriginInSource() - state.subject->center_in_world).norm();
  const double wanted = state.guidance.distance;
  if (wanted > 0 && now > kFarOff * wanted) return {"come " + Percent(wanted / now) + " nearer", false};
  if (wanted > 0 && wanted > kFarOff * now) return {"go " + Percent(wanted / now) + " back", false};
  if (const auto& row = state.guidance.row; row && row->wanted > 0) {
    if (row->now > kRowFarOff * row->wanted) return {"too far from the last row: move towards it", false};
    if (row->now < kRowNarrow * row->wanted) return {"too near to the last row: move away from it", false};
  }
  if (state.guidance.toward) return {"follow the arrow", false};
  return {};
}

}  // namespace ulf
