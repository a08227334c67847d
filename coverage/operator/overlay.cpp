#include "coverage/operator/overlay.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/geometry/angles.h"
#include "core/geometry/small_matrices.h"
#include "coverage/bound/sphere_outline.h"

namespace ulf::coverage {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

const render::Rgba kWhiteLine{255, 255, 255}, kShade{0, 0, 0, 190};

// The shown sphere with the camera that projects its directions into the picture.
struct Sphere {
  const ShownSphere& shown;
  const CameraModel& camera;

  std::optional<Vector2d> ImgOf(const Vector3d& direction) const {
    return camera.ImgFromCam(shown.PointInCam(direction));
  }
  std::optional<Vector2d> ImgOfFacing(const Vector3d& direction) const {
    return shown.Faces(direction) ? ImgOf(direction) : std::nullopt;
  }
};

// Returns the parts of a curve over the sphere, t from 0 to 1, that face the camera.
template <typename DirectionAt>
void AddCurve(const Sphere& sphere, const DirectionAt& direction_at, int steps, double width,
              const render::Rgba& color, render::Overlay& overlay) {
  render::Polyline part{.img = {}, .width = width, .color = color};
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

void AddCircle(const Sphere& sphere, const Vector3d& around, double radius, double width,
               const render::Rgba& color, render::Overlay& overlay) {
  const Vector3d x = around.unitOrthogonal(), y = around.cross(x);
  const auto at = [&](double t) -> Vector3d {
    const double turn = 2 * M_PI * t;
    return std::cos(radius) * around + std::sin(radius) * (std::cos(turn) * x + std::sin(turn) * y);
  };
  AddCurve(sphere, at, 32, width, color, overlay);
}

void AddWireframe(const Sphere& sphere, const render::Rgba& color, render::Overlay& overlay) {
  const CapFrame& frame = sphere.shown.frame;
  constexpr int kSpacingDeg = 10;
  for (int deg = -180; deg < 180; deg += kSpacingDeg)
    AddCurve(
        sphere, [&](double t) { return frame.Direction(Radians(deg), (t - 0.5) * M_PI); }, 45, 1, color,
        overlay);
  for (int deg = -80; deg <= 80; deg += kSpacingDeg)
    AddCurve(
        sphere, [&](double t) { return frame.Direction((2 * t - 1) * M_PI, Radians(deg)); }, 90, 1, color,
        overlay);
}

void AddPaint(const Sphere& sphere, const Palette& palette, render::Overlay& overlay) {
  const CapFrame& frame = sphere.shown.frame;
  for (const ShownSphere::Paint& paint : sphere.shown.paint) {
    const std::array directions{
        frame.Direction(paint.left, paint.bottom), frame.Direction(paint.right, paint.bottom),
        frame.Direction(paint.right, paint.top), frame.Direction(paint.left, paint.top)};
    render::Patch patch{.img = {}, .color = palette.OfNearer(paint.nearer).WithOpacity(0.72)};
    bool whole = true;
    for (std::size_t i = 0; i < directions.size() && whole; ++i) {
      const auto img = sphere.ImgOf(directions[i]);
      whole = img.has_value();
      if (whole) patch.img[i] = *img;
    }
    if (whole) overlay.push_back(patch);
  }
}

// A letter for the cause where a view was recorded and the pictures are wrong: the worst first, and none so
// near to another that they could not be read.
void AddCauses(const Sphere& sphere, render::Overlay& overlay) {
  const double apart = 0.025 * sphere.camera.width;
  std::vector<const ShownSphere::Error*> marked;
  for (const ShownSphere::Error& error : sphere.shown.errors)
    if (error.marked && *LetterOf(error.cause)) marked.push_back(&error);
  std::ranges::stable_sort(marked, {}, &ShownSphere::Error::db_above_goal);
  std::vector<Vector2d> placed;
  for (const ShownSphere::Error* error : marked) {
    const auto img = sphere.ImgOf(error->direction);
    if (!img || std::ranges::any_of(placed, [&](const Vector2d& at) { return (at - *img).norm() < apart; }))
      continue;
    placed.push_back(*img);
    overlay.push_back(
        render::Label{.img = *img, .text = LetterOf(error->cause), .size = 13, .color = {20, 20, 20}});
  }
}

void AddErrors(const Sphere& sphere, const Palette& palette, render::Overlay& overlay) {
  constexpr double kRadius = Radians(1.1);
  constexpr int kCorners = 10;
  for (const ShownSphere::Error& error : sphere.shown.errors) {
    const Vector3d x = error.direction.unitOrthogonal(), y = error.direction.cross(x);
    render::Polygon disc{.img = {}, .color = palette.OfError(error.db_above_goal).WithOpacity(0.85)};
    for (int i = 0; i < kCorners; ++i) {
      const double turn = 2 * M_PI * i / kCorners;
      const auto img = sphere.ImgOf(std::cos(kRadius) * error.direction +
                                    std::sin(kRadius) * (std::cos(turn) * x + std::sin(turn) * y));
      if (img) disc.img.push_back(*img);
    }
    if (disc.img.size() == kCorners) overlay.push_back(disc);
  }
  AddCauses(sphere, overlay);
}

void AddViews(const Sphere& sphere, render::Overlay& overlay) {
  const render::Rgba rim{10, 10, 10, 150}, middle{10, 10, 10, 210};
  for (const ShownSphere::View& view : sphere.shown.views) {
    const auto img = sphere.ImgOf(view.direction);
    if (!img) continue;
    overlay.push_back(render::Spot{*img, 1.6, middle});
    if (view.rim > 0) AddCircle(sphere, view.direction, view.rim, 1.2, rim, overlay);
  }
}

void AddCapOutline(const Sphere& sphere, const Cap& cap, render::Overlay& overlay) {
  const CapFrame& frame = sphere.shown.frame;
  const double x = 0.5 * cap.width, y = 0.5 * cap.height;
  for (const auto& [width, color] : {std::pair{5.0, kShade}, std::pair{2.5, kWhiteLine}})
    for (const double side : {-1.0, 1.0}) {
      AddCurve(
          sphere, [&](double t) { return frame.Direction(side * x, (2 * t - 1) * y); }, 60, width, color,
          overlay);
      AddCurve(
          sphere, [&](double t) { return frame.Direction((2 * t - 1) * x, side * y); }, 60, width, color,
          overlay);
    }
}

// Small marks with a rim, which is visible on any colour.
void AddMarks(const Sphere& sphere, const std::vector<Vector3d>& directions, double radius,
              const render::Rgba& color, render::Overlay& overlay) {
  for (const Vector3d& direction : directions) {
    const auto img = sphere.ImgOf(direction);
    if (!img) continue;
    overlay.push_back(render::Spot{*img, radius + 1, kWhiteLine.WithOpacity(0.8)});
    overlay.push_back(render::Spot{*img, radius, color});
  }
}

void AddArrow(const std::vector<Vector2d>& img, double width, double head, const render::Rgba& color,
              render::Overlay& overlay) {
  const Vector2d tip = img.back();
  // The head points along the last part of the way, which is about as long as the head.
  const auto behind_head = std::find_if(img.rbegin(), img.rend(),
                                        [&](const Vector2d& at) { return (at - tip).norm() > 0.7 * head; });
  const Vector2d from = behind_head == img.rend() ? img.front() : *behind_head;
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
    overlay.push_back(render::Polyline{shaft, width + 3, kShade});
  }
  overlay.push_back(render::Polygon{head_of(0.15 * head), kShade});
  if (shaft.size() > 1) overlay.push_back(render::Polyline{shaft, width, color});
  overlay.push_back(render::Polygon{head_of(0), color});
}

// Draws the way from the red dot over the sphere to the next view's place.
void AddGuidance(const Sphere& sphere, const Palette& palette, render::Overlay& overlay) {
  AddMarks(sphere, sphere.shown.left_open, 2.2, palette.guide, overlay);
  if (!sphere.shown.target) return;
  const ShownSphere::Target& target = *sphere.shown.target;
  if (!target.hidden) {
    AddCircle(sphere, target.direction, target.ring, 6, kShade, overlay);
    AddCircle(sphere, target.direction, target.ring, 3, palette.guide, overlay);
  }
  const double away = sphere.shown.AngleFromDot(target.direction);
  if (away < 1.2 * target.ring) return;
  // The arrow ends at the ring, which stays free, or at the limb where the target is hidden.
  const double end = target.hidden ? 0.97 * away : away - 0.9 * target.ring;
  std::vector<Vector2d> way;
  constexpr int kSteps = 24;
  for (int i = 0; i <= kSteps; ++i)
    if (const auto img = sphere.ImgOf(sphere.shown.Along(target.direction, end * i / kSteps)))
      way.push_back(*img);
  if (way.size() > 1)
    AddArrow(way, 5, std::clamp(0.45 * (way.back() - way.front()).norm(), 8.0, 0.03 * sphere.camera.width),
             palette.guide, overlay);
}

void AddPresentCamera(const Sphere& sphere, const Palette& palette, render::Overlay& overlay) {
  const auto img = sphere.ImgOf(sphere.shown.toward_camera);
  if (!img) return;
  overlay.push_back(render::Spot{*img, 8, {0, 0, 0, 120}});
  overlay.push_back(render::Spot{*img, 7, kWhiteLine});
  overlay.push_back(render::Spot{*img, 5, palette.camera});
}

// Draws an arrow towards something outside the picture.
void AddWayOut(const Vector2d& toward, const char* to, const render::Rgba& color,
               const SafetyRectangle& rectangle, render::Overlay& overlay) {
  const Vector2d middle = 0.5 * (rectangle.low + rectangle.high),
                 half = 0.5 * (rectangle.high - rectangle.low);
  const double to_border = 1 / (toward.cwiseAbs().cwiseQuotient(half)).maxCoeff();
  const Vector2d tip = middle + 0.94 * to_border * toward;
  const double length = 0.3 * half.y();
  std::vector<Vector2d> way;
  for (int i = 0; i <= 8; ++i) way.push_back(tip - length * (1 - i / 8.0) * toward);
  AddArrow(way, 12, 0.45 * length, color, overlay);
  overlay.push_back(
      render::Label{.img = tip - 1.35 * length * toward, .text = to, .size = 22, .color = kWhiteLine});
}

// Shows where the last picture with a pose lies, or the first one, after the turn of the camera since then.
void AddPictureOfThen(const CaptureState& state, const Palette& palette, render::Overlay& overlay) {
  const CameraTurn& turned = *state.turned;
  const render::Rgba color = turned.reference_has_pose ? palette.guide : kWhiteLine;
  for (const std::vector<Vector2d>& line : FormerFrameOutline(turned, state.camera)) {
    overlay.push_back(render::Polyline{line, 5, {0, 0, 0, 110}});
    overlay.push_back(render::Polyline{line, 3, color});
  }
  const SafetyRectangle rectangle = SafetyRectangle::Of(state.camera);
  const Vector3d there = turned.ReferenceAxis();
  const auto img = there.z() > 0 ? state.camera.ImgFromCam(there) : std::nullopt;
  if (img && state.camera.Contains(*img)) {
    if (turned.Angle() > Radians(kReachedDeg))
      overlay.push_back(
          render::Label{.img = *img,
                        .text = turned.reference_has_pose ? "it looked here last" : "it began here",
                        .size = 20,
                        .color = color});
    return;
  }
  if (!turned.reference_has_pose) return;
  const Vector2d toward = there.head<2>();
  // Straight behind can be reached by turning either way.
  AddWayOut(toward.norm() > 1e-9 ? Vector2d(toward.normalized()) : Vector2d(1, 0), "back", palette.guide,
            rectangle, overlay);
}

void AddRectangle(const SafetyRectangle& rectangle, bool held, const Palette& palette,
                  render::Overlay& overlay) {
  const Vector2d low = rectangle.low, high = rectangle.high;
  const std::vector<Vector2d> corners{low, {high.x(), low.y()}, high, {low.x(), high.y()}};
  overlay.push_back(render::Polyline{corners, held ? 4.0 : 9.0, {0, 0, 0, 110}, true});
  overlay.push_back(render::Polyline{corners, held ? 2.0 : 6.0, held ? kWhiteLine : palette.alarm, true});
  if (!held)
    overlay.push_back(render::Label{.img = {0.5 * (low.x() + high.x()), low.y()},
                                    .text = "OUTSIDE",
                                    .size = 30,
                                    .color = palette.alarm,
                                    .anchor = {0.5, -0.3}});
}

void AddOutline(const Sphere& sphere, double width, const render::Rgba& color, const render::Rgba& fill,
                render::Overlay& overlay) {
  const auto outline =
      SphereOutline(sphere.camera, {}, {-sphere.shown.toward_camera, sphere.shown.radius}, 96);
  if (!outline) return;
  if (fill.a > 0) overlay.push_back(render::Polygon{*outline, fill});
  overlay.push_back(render::Polyline{*outline, width, color, true});
}

// The sphere and all that is drawn on it, with the camera outside.
void AddSphere(const ShownSphere& shown, const CameraModel& camera, const Palette& palette, SphereLayer layer,
               render::Overlay& overlay) {
  const Sphere sphere{shown, camera};
  // Open cells are dark, so that the sphere is visible before anything is painted.
  AddOutline(sphere, 1.5, kWhiteLine.WithOpacity(0.8), {25, 25, 30, 110}, overlay);
  if (layer == SphereLayer::kErrors)
    AddErrors(sphere, palette, overlay);
  else
    AddPaint(sphere, palette, overlay);
  AddWireframe(sphere, kWhiteLine.WithOpacity(0.4), overlay);
  AddViews(sphere, overlay);
  if (shown.cap) AddCapOutline(sphere, *shown.cap, overlay);
  AddMarks(sphere, shown.reopened, 3, palette.reopened, overlay);
  AddGuidance(sphere, palette, overlay);
  AddPresentCamera(sphere, palette, overlay);
}

void AddProposal(const CameraModel& camera, const Rigid3& cam_from_world, const Subject& subject,
                 const Palette& palette, render::Overlay& overlay) {
  const auto outline = SphereOutline(camera, cam_from_world, subject);
  if (!outline) return;
  // Every other side makes it dashed.
  for (std::size_t i = 0; i + 1 < outline->size(); i += 2)
    overlay.push_back(
        render::Polyline{.img = {(*outline)[i], (*outline)[i + 1]}, .width = 3, .color = palette.guide});
  const auto top = std::ranges::min_element(*outline, {}, [](const Vector2d& at) { return at.y(); });
  overlay.push_back(render::Label{.img = *top - Vector2d(0, 0.01 * camera.height),
                                  .text = "the subject's size (G)",
                                  .size = 17,
                                  .color = kWhiteLine,
                                  .anchor = {0.5, 1}});
}

}  // namespace

render::Overlay SphereOverlay(const CameraModel& camera, const Rigid3& cam_from_world, const Subject& subject,
                              const render::Rgba& color) {
  render::Overlay overlay;
  CaptureState state;
  state.cam_from_world = cam_from_world;
  state.subject = subject;
  const auto shown = ShownSphere::Of(state);
  if (!shown) return overlay;
  AddWireframe({*shown, camera}, color.WithOpacity(0.6), overlay);
  AddOutline({*shown, camera}, 2, color, {0, 0, 0, 0}, overlay);
  return overlay;
}

const char* LetterOf(render::ErrorCause cause) {
  constexpr std::array kLetters{"", "U", "P", "L", "F", "M", "G", "S", "D"};
  static_assert(kLetters.size() == render::kErrorCauses.size());
  return kLetters[static_cast<std::size_t>(cause)];
}

render::Overlay MakeOverlay(const CaptureState& state, const Palette& palette, SphereLayer layer) {
  render::Overlay overlay;
  const ShownPicture shown = ShownPicture::Of(state);
  if (state.turned && state.tracking != tracking::TrackState::kApart)
    AddPictureOfThen(state, palette, overlay);
  if (!shown.rectangle) return overlay;
  if (shown.sphere) AddSphere(*shown.sphere, shown.camera, palette, layer, overlay);
  if (state.proposed_subject && state.cam_from_world)
    AddProposal(state.camera, *state.cam_from_world, *state.proposed_subject, palette, overlay);
  AddRectangle(*shown.rectangle, shown.held, palette, overlay);
  if (shown.way_to_subject && !IsTaken(state.source))
    AddWayOut(*shown.way_to_subject, "subject", palette.alarm, *shown.rectangle, overlay);
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
  constexpr double kDiscShare = 0.11;  // a disc's radius, of the height: its neighbours are shown, too
  const double disc_radius = map.spacing() * map.options().cells_per_disc_radius;
  const double focal_px = kDiscShare * height * to_surface / (state.subject->radius * disc_radius);
  CaptureState close = state;
  // Aimed at the subject, with the live picture's roll: what moves left there moves left here.
  const auto aimed = TurnBetween(center_in_cam, Vector3d::UnitZ());
  close.cam_from_world = Rigid3{aimed, Vector3d::Zero()} * *state.cam_from_world;
  CloseLook look{.size = {width, height}, .shapes = {}};
  // Leaves out what lies beyond the picture's corners.
  const double corner = 0.5 * std::hypot(width, height) / (kDiscShare * height) * disc_radius;
  if (const auto shown = ShownSphere::Of(close, std::min(M_PI, 1.5 * corner + 0.1)))
    AddSphere(*shown, CameraModel::Pinhole(width, height, focal_px), palette, SphereLayer::kCoverage,
              look.shapes);
  return look;
}

}  // namespace ulf::coverage
