#include "coverage/operator/review.h"

#include <algorithm>
#include <cmath>

#include "tracking/marker_locator.h"

namespace ulf {
namespace {

using Eigen::Vector3d;

constexpr double kDegree = M_PI / 180;

// What the marker as a mouse wants to know of a light field: where it was seen from.
RenderScene ViewpointsOf(const CaptureState& state) {
  RenderScene scene;
  scene.subject = *state.subject;
  for (const CriterionView& view : state.coverage->views()) {
    SceneView& seen = scene.views.emplace_back();
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
  if (!marker_.empty()) MarkerSpec::Parse(marker_);  // throws where it is none
}
Review::~Review() = default;

void Review::Open(const CaptureState& state) {
  open_ = true;
  StartOrbit(state);
}

void Review::StartOrbit(const CaptureState& state) {
  if (!HasViews(state)) return;
  orbit_frame_ = *state.coverage->frame();
  distance_ = state.coverage->reference_distance();
  azimuth_ = elevation_ = 0;
  if (!state.cam_from_world) return;
  const Vector3d offset = state.cam_from_world->OriginInSource() - state.subject->center_in_world;
  const CapFrame::Angles angles = orbit_frame_->Of(offset.normalized());
  azimuth_ = angles.azimuth;
  elevation_ = angles.elevation;
  distance_ = offset.norm();
}

void Review::Orbit(double azimuth, double elevation) {
  constexpr double kSteepest = 80 * kDegree;
  azimuth_ = std::remainder(azimuth_ + azimuth, 2 * M_PI);
  elevation_ = std::clamp(elevation_ + elevation, -kSteepest, kSteepest);
  control_ = Control::kMouseAndKeys;
}

bool Review::Handle(const InputEvent& event, const CaptureState& state) {
  constexpr double kStep = 2 * kDegree, kZoom = 1.05, kWipeStep = 0.05;
  if (!open_) return false;
  if (const auto* key = std::get_if<KeyPressed>(&event)) {
    switch (key->key) {
      case Key::kEscape:
        open_ = false;
        return true;
      case Key::kLeft:
        Orbit(-kStep, 0);
        return true;
      case Key::kRight:
        Orbit(kStep, 0);
        return true;
      case Key::kUp:
        Orbit(0, kStep);
        return true;
      case Key::kDown:
        Orbit(0, -kStep);
        return true;
      case Key::kPageUp:
        distance_ /= kZoom;
        return true;
      case Key::kPageDown:
        distance_ *= kZoom;
        return true;
      default:
        return false;
    }
  }
  if (const auto* typed = std::get_if<Typed>(&event)) {
    switch (typed->character) {
      case 'r':
        open_ = false;
        return true;
      case 'c':
        control_ = control_ == Control::kLiveCamera                         ? Control::kMouseAndKeys
                   : control_ == Control::kMouseAndKeys && !marker_.empty() ? Control::kMarker
                                                                            : Control::kLiveCamera;
        if (control_ == Control::kMouseAndKeys) StartOrbit(state);
        return true;
      case 'w':
        compare_ = compare_ == Compare::kWipe ? Compare::kNone : Compare::kWipe;
        control_ = Control::kLiveCamera;
        return true;
      case 'b':
        compare_ = compare_ == Compare::kBlink ? Compare::kNone : Compare::kBlink;
        control_ = Control::kLiveCamera;
        return true;
      case ',':
        wipe_ = std::max(0.0, wipe_ - kWipeStep);
        return true;
      case '.':
        wipe_ = std::min(1.0, wipe_ + kWipeStep);
        return true;
      default:
        return false;
    }
  }
  if (const auto* wheel = std::get_if<WheelTurned>(&event)) {
    distance_ *= std::pow(kZoom, -wheel->steps);
    return true;
  }
  if (const auto* button = std::get_if<MouseButton>(&event)) {
    if (button->button == 0) dragging_ = button->down;
    return true;
  }
  if (const auto* moved = std::get_if<MouseMoved>(&event)) {
    constexpr double kRadiansAPixel = 0.25 * kDegree;
    // The subject follows the hand: the camera goes the other way.
    if (mouse_ && dragging_)
      Orbit(-kRadiansAPixel * (moved->at.x() - mouse_->x()), kRadiansAPixel * (moved->at.y() - mouse_->y()));
    mouse_ = moved->at;
    return true;
  }
  return false;
}

std::optional<Rigid3> Review::OrbitPose(const CaptureState& state) const {
  if (!orbit_frame_ || !state.subject) return std::nullopt;
  const Vector3d& center = state.subject->center_in_world;
  return LookAt(center + distance_ * orbit_frame_->Direction(azimuth_, elevation_), center,
                orbit_frame_->Up());
}

std::optional<Rigid3> Review::MarkerPose(const CaptureState& state) {
  if (!HasViews(state)) return std::nullopt;
  if (!locator_) {
    const MarkerSpec spec = MarkerSpec::Parse(marker_);
    locator_ = std::make_unique<MarkerLocator>(state.camera, spec);
    marker_mouse_.emplace(ViewpointsOf(state), spec.Middle());
  }
  if (state.device_time_s != located_at_s_) {
    located_at_s_ = state.device_time_s;
    const auto pose = locator_->Locate(GrayForTracking(state.live), state.device_time_s);
    marker_is_seen_ = pose.has_value();
    if (pose) marker_pose_ = marker_mouse_->CamFromWorld(pose->cam_from_world);
  }
  return marker_pose_;  // without the marker the last picture stays
}

std::optional<Review::VirtualCamera> Review::CameraNow(const CaptureState& state) {
  std::optional<Rigid3> pose;
  switch (control_) {
    case Control::kLiveCamera:
      if (state.cam_from_world) return VirtualCamera{state.camera, *state.cam_from_world};
      return std::nullopt;
    case Control::kMouseAndKeys:
      if (!orbit_frame_) StartOrbit(state);
      pose = OrbitPose(state);
      break;
    case Control::kMarker:
      pose = MarkerPose(state);
      break;
  }
  if (!pose) return std::nullopt;
  return VirtualCamera{state.camera.WithoutDistortion(), *pose};
}

std::vector<WeightedPicture> Review::Nearest(const std::map<int, PosedPicture>& pictures,
                                             const Vector3d& subject_in_world, const Rigid3& cam_from_world) {
  constexpr std::size_t kMost = 3;
  const Vector3d direction = (cam_from_world.OriginInSource() - subject_in_world).normalized();
  struct Found {
    double angle;
    const PosedPicture* picture;
  };
  std::vector<Found> found;
  for (const auto& [id, picture] : pictures) {
    const Vector3d of_picture = (picture.cam_from_world.OriginInSource() - subject_in_world).normalized();
    found.push_back({std::acos(std::clamp(direction.dot(of_picture), -1.0, 1.0)), &picture});
  }
  const std::size_t count = std::min(found.size(), kMost + 1);
  std::partial_sort(found.begin(), found.begin() + static_cast<long>(count), found.end(),
                    [](const Found& a, const Found& b) { return a.angle < b.angle; });
  std::vector<WeightedPicture> nearest;
  const double end = count > kMost ? found[kMost].angle : 2 * (count > 0 ? found[count - 1].angle : 0) + 1e-6;
  for (std::size_t i = 0; i < std::min(count, kMost); ++i) {
    const double share = 1 - found[i].angle / std::max(end, 1e-9);
    if (i == 0 || share > 0.01)
      nearest.push_back({found[i].picture, static_cast<float>(std::max(0.01, share * share))});
  }
  return nearest;
}

}  // namespace ulf
