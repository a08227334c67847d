#include "coverage/operator/review.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "core/geometry/angles.h"
#include "coverage/operator/key_actions.h"
#include "tracking/sources/marker_locator.h"

namespace ulf::coverage {
namespace {

using Eigen::Vector3d;

// Returns the viewpoints, as a scene for MarkerMouse.
render::RenderScene ViewpointsOf(const CaptureState& state) {
  render::RenderScene scene;
  scene.subject = *state.subject;
  for (const CriterionView& view : state.coverage->views()) {
    render::SceneView& seen = scene.views.emplace_back();
    seen.center_in_world = view.center_in_world;
  }
  scene.up_in_world = state.coverage->frame()->Up();
  return scene;
}

bool HasViews(const CaptureState& state) {
  return state.subject && state.coverage && !state.coverage->views().empty();
}

}  // namespace

Review::Review(std::string marker) : marker_(std::move(marker)) {
  if (!marker_.empty()) tracking::MarkerSpec::Parse(marker_);  // throws where it is none
}
Review::~Review() = default;

Vector3d Review::Orbit::Center() const {
  return subject.center_in_world + distance * frame.Direction(azimuth, elevation);
}

std::optional<Review::Orbit> Review::OrbitAt(const CaptureState& state, const Vector3d& center_in_world) {
  if (!HasViews(state)) return std::nullopt;
  const CapFrame& frame = *state.coverage->frame();
  const Vector3d offset = center_in_world - state.subject->center_in_world;
  const CapFrame::Angles angles = frame.Of(offset.normalized());
  return Orbit{*state.subject, frame, angles.azimuth, angles.elevation, offset.norm()};
}

void Review::Open(const CaptureState& state) {
  open_ = true;
  StartOrbit(state);
}

void Review::StartOrbit(const CaptureState& state) {
  if (!HasViews(state)) return;
  const Vector3d before_the_first_view =
      state.subject->center_in_world +
      state.coverage->reference_distance() * state.coverage->frame()->Direction(0, 0);
  orbit_ =
      OrbitAt(state, state.cam_from_world ? state.cam_from_world->OriginInSource() : before_the_first_view);
}

void Review::FollowSubject(const CaptureState& state) {
  if (orbit_ && orbit_->subject != state.subject) orbit_ = OrbitAt(state, orbit_->Center());
  // Corrected poses turn the frame a little.
  if (orbit_ && HasViews(state)) orbit_->frame = *state.coverage->frame();
  if (!orbit_) StartOrbit(state);
  if (mouse_subject_ != state.subject) marker_mouse_.reset();
}

void Review::Turn(double azimuth, double elevation) {
  constexpr double kSteepest = Radians(80);
  control_ = Control::kMouseAndKeys;
  if (!orbit_) return;
  orbit_->azimuth = std::remainder(orbit_->azimuth + azimuth, 2 * M_PI);
  orbit_->elevation = std::clamp(orbit_->elevation + elevation, -kSteepest, kSteepest);
}

void Review::Zoom(double factor) {
  if (orbit_) orbit_->distance *= factor;
}

void Review::NextControl(const CaptureState& state) {
  control_ = control_ == Control::kLiveCamera                         ? Control::kMouseAndKeys
             : control_ == Control::kMouseAndKeys && !marker_.empty() ? Control::kMarker
                                                                      : Control::kLiveCamera;
  if (control_ == Control::kMouseAndKeys) StartOrbit(state);
}

void Review::ToggleCompare(Compare compare) {
  compare_ = compare_ == compare ? Compare::kNone : compare;
  control_ = Control::kLiveCamera;
}

bool Review::Handle(const render::InputEvent& event, const CaptureState& state) {
  constexpr double kStep = Radians(2), kZoom = 1.05, kWipeStep = 0.05;
  if (!open_) return false;
  if (const auto* key = std::get_if<render::KeyPressed>(&event))
    return RunAction(key->key, {{render::Key::kEscape, [&] { open_ = false; }},
                                {render::Key::kLeft, [&] { Turn(-kStep, 0); }},
                                {render::Key::kRight, [&] { Turn(kStep, 0); }},
                                {render::Key::kUp, [&] { Turn(0, kStep); }},
                                {render::Key::kDown, [&] { Turn(0, -kStep); }},
                                {render::Key::kPageUp, [&] { Zoom(1 / kZoom); }},
                                {render::Key::kPageDown, [&] { Zoom(kZoom); }}});
  if (const auto* typed = std::get_if<render::Typed>(&event))
    return RunAction(typed->character, {{U'r', [&] { open_ = false; }},
                                        {U'c', [&] { NextControl(state); }},
                                        {U'w', [&] { ToggleCompare(Compare::kWipe); }},
                                        {U'b', [&] { ToggleCompare(Compare::kBlink); }},
                                        {U',', [&] { wipe_ = std::max(0.0, wipe_ - kWipeStep); }},
                                        {U'.', [&] { wipe_ = std::min(1.0, wipe_ + kWipeStep); }}});
  if (const auto* wheel = std::get_if<render::WheelTurned>(&event)) {
    Zoom(std::pow(kZoom, -wheel->steps));
    return true;
  }
  if (const auto* button = std::get_if<render::MouseButton>(&event)) {
    if (button->button == 0) dragging_ = button->down;
    return true;
  }
  if (const auto* moved = std::get_if<render::MouseMoved>(&event)) {
    constexpr double kRadiansAPixel = Radians(0.25);
    // The subject follows the mouse: the camera moves the other way.
    if (mouse_ && dragging_)
      Turn(-kRadiansAPixel * (moved->at.x() - mouse_->x()), kRadiansAPixel * (moved->at.y() - mouse_->y()));
    mouse_ = moved->at;
    return true;
  }
  return false;
}

std::optional<Rigid3> Review::MarkerPose(const CaptureState& state) {
  if (!HasViews(state)) return std::nullopt;
  const tracking::MarkerSpec spec = tracking::MarkerSpec::Parse(marker_);
  if (std::exchange(lens_, state.camera) != state.camera || !locator_)
    locator_ = std::make_unique<tracking::MarkerLocator>(state.camera, spec);
  if (!marker_mouse_) {
    mouse_subject_ = state.subject;
    marker_mouse_.emplace(ViewpointsOf(state), spec.Middle());
  }
  if (state.device_time_s != located_at_s_) {
    located_at_s_ = state.device_time_s;
    const auto pose = locator_->Locate(GrayForTracking(state.live), state.device_time_s);
    marker_is_seen_ = pose.has_value();
    if (pose) cam_from_marker_ = pose->cam_from_world;
  }
  if (!cam_from_marker_) return std::nullopt;
  return marker_mouse_->CamFromWorld(*cam_from_marker_);  // without the marker the last picture stays
}

std::optional<Review::VirtualCamera> Review::CameraNow(const CaptureState& state) {
  FollowSubject(state);
  std::optional<Rigid3> pose;
  switch (control_) {
    case Control::kLiveCamera:
      if (state.cam_from_world) return VirtualCamera{state.camera, *state.cam_from_world};
      return std::nullopt;
    case Control::kMouseAndKeys:
      if (orbit_) pose = LookAt(orbit_->Center(), orbit_->subject.center_in_world, orbit_->frame.Up());
      break;
    case Control::kMarker:
      pose = MarkerPose(state);
      break;
  }
  if (!pose) return std::nullopt;
  return VirtualCamera{state.camera.WithoutDistortion(), *pose};
}

std::optional<MarkedView> MarkNearestView(const CaptureState& state, const PendingRequests& pending,
                                          const CameraModel& camera, const Rigid3& cam_from_world,
                                          const Palette& palette) {
  if (!state.subject || !state.coverage) return std::nullopt;
  const Vector3d& center = state.subject->center_in_world;
  const Vector3d offset = cam_from_world.OriginInSource() - center;
  std::optional<std::size_t> nearest;
  Vector3d nearest_direction = Vector3d::Zero();
  for (std::size_t i = 0; i < state.view_ids.size(); ++i) {
    const Vector3d direction = (state.coverage->views()[i].center_in_world - center).normalized();
    if (pending.IsTakenBack(state.view_ids[i])) continue;
    if (nearest && direction.dot(offset) <= nearest_direction.dot(offset)) continue;
    nearest = i;
    nearest_direction = direction;
  }
  if (!nearest) return std::nullopt;
  MarkedView marked{.id = state.view_ids[*nearest], .shapes = {}};
  // The camera does not see the sphere's far side.
  if (nearest_direction.dot(offset) < state.subject->radius) return marked;
  const auto img =
      camera.ImgFromCam(cam_from_world * Vector3d(center + state.subject->radius * nearest_direction));
  if (!img || !camera.Contains(*img)) return marked;
  marked.shapes = {render::Spot{*img, 8, {0, 0, 0, 120}}, render::Spot{*img, 7, {255, 255, 255}},
                   render::Spot{*img, 5, palette.guide},
                   render::Label{.img = *img + Eigen::Vector2d(0, -0.02 * camera.height),
                                 .text = fmt::format("view {}", marked.id),
                                 .size = 17,
                                 .color = {255, 255, 255},
                                 .anchor = {0.5, 1}}};
  return marked;
}

}  // namespace ulf::coverage
