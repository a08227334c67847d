#include "coverage/operator/subject_tool.h"

#include <cmath>
#include <utility>

#include "coverage/operator/key_actions.h"

namespace ulf::coverage {

using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {
constexpr double kFine = 1.02, kCoarse = 1.15;  // factors of one step; guessed
}

void SubjectTool::Open(const CaptureState& state, PendingRequests& pending) {
  open_ = true;
  before_ = draft_ = of_capture_ = pending.SubjectOf(state);
  found_anew_ = awaits_found_ = false;
  paused_.reset();
  if (pending.Records(state)) {
    pending.Record(false);
    paused_ = pending.record_ticket();
  }
  if (!draft_ && state.cam_from_world) pending.FindSubject();
}

void SubjectTool::Close(PendingRequests& pending) {
  open_ = dragging_center_ = dragging_radius_ = false;
  draft_.reset();
  if (paused_ == pending.record_ticket()) pending.Record(true);
  paused_.reset();
}

// Restores the subject from before the tool was opened, where the capture was asked to find another.
void SubjectTool::Leave(PendingRequests& pending) {
  if (found_anew_ && before_) pending.Place(*before_);
  Close(pending);
}

void SubjectTool::TakeOver(PendingRequests& pending) {
  if (draft_ && draft_ != of_capture_) pending.Place(*draft_);
  Close(pending);
}

void SubjectTool::FindAnew(PendingRequests& pending) {
  found_anew_ = awaits_found_ = true;
  pending.FindSubject();
}

void SubjectTool::Follow(const CaptureState& state, const PendingRequests& pending) {
  const std::optional<Subject> now = pending.SubjectOf(state);
  if (!open_ || now == of_capture_) return;
  const std::optional<Subject> before = std::exchange(of_capture_, now);
  if (!now || !before || !draft_ || std::exchange(awaits_found_, false)) {
    draft_ = now;
    return;
  }
  // The capture's subject has followed a corrected map: so do the one that is being placed, and the one of
  // before.
  for (std::optional<Subject>* follows : {&draft_, &before_})
    if (*follows) {
      (*follows)->center_in_world += now->center_in_world - before->center_in_world;
      (*follows)->radius *= now->radius / before->radius;
    }
}

void SubjectTool::ScaleDistance(const CaptureState& state, double factor) {
  if (!draft_ || !state.cam_from_world) return;
  // The radius grows with the distance, so that the sphere's image stays the same.
  const Vector3d camera = state.cam_from_world->OriginInSource();
  draft_->center_in_world = camera + factor * (draft_->center_in_world - camera);
  draft_->radius *= factor;
}

void SubjectTool::ScaleRadius(double factor) {
  if (draft_) draft_->radius *= factor;
}

void SubjectTool::MoveSideways(const CaptureState& state, const Vector2d& by_img) {
  if (!draft_ || !state.cam_from_world) return;
  const double depth = (*state.cam_from_world * draft_->center_in_world).z();
  if (!(depth > 0)) return;
  const Vector3d by_cam(by_img.x() * depth / state.camera.fx, by_img.y() * depth / state.camera.fy, 0);
  draft_->center_in_world += state.cam_from_world->DirectionInSource(by_cam);
}

bool SubjectTool::Press(const render::KeyPressed& key, const CaptureState& state, PendingRequests& pending) {
  constexpr double kStepShare = 0.01;  // of the picture's width, across it
  const double step = kStepShare * state.camera.width;
  const auto across = [&](double x, double y) { MoveSideways(state, {x * step, y * step}); };
  return RunAction(key.key,
                   {{render::Key::kUp, [&] { key.shift ? across(0, -1) : ScaleDistance(state, kFine); }},
                    {render::Key::kDown, [&] { key.shift ? across(0, 1) : ScaleDistance(state, 1 / kFine); }},
                    {render::Key::kRight, [&] { key.shift ? across(1, 0) : ScaleRadius(kFine); }},
                    {render::Key::kLeft, [&] { key.shift ? across(-1, 0) : ScaleRadius(1 / kFine); }},
                    {render::Key::kPageUp, [&] { ScaleDistance(state, kCoarse); }},
                    {render::Key::kPageDown, [&] { ScaleDistance(state, 1 / kCoarse); }},
                    {render::Key::kEnter, [&] { TakeOver(pending); }},
                    {render::Key::kEscape, [&] { Leave(pending); }}});
}

bool SubjectTool::Handle(const render::InputEvent& event, const CaptureState& state, double pixels_per_img,
                         PendingRequests& pending) {
  if (!open_) return false;
  if (const auto* key = std::get_if<render::KeyPressed>(&event)) return Press(*key, state, pending);
  if (const auto* typed = std::get_if<render::Typed>(&event))
    return RunAction(typed->character, {{U's', [&] { Leave(pending); }},
                                        {U'c', [&] { FindAnew(pending); }},
                                        {U'a', [&] { aperture_ = !aperture_; }}});
  if (const auto* wheel = std::get_if<render::WheelTurned>(&event)) {
    if (wheel->shift)
      ScaleRadius(std::pow(kFine, wheel->steps));
    else
      ScaleDistance(state, std::pow(kFine, wheel->steps));
    return true;
  }
  if (const auto* button = std::get_if<render::MouseButton>(&event)) {
    if (button->button == 0) dragging_center_ = button->down;
    if (button->button == 1) dragging_radius_ = button->down;
    return true;
  }
  if (const auto* moved = std::get_if<render::MouseMoved>(&event)) {
    if (mouse_) {
      const Vector2d by = moved->at - *mouse_;
      constexpr double kPixelsADoubling = 200;
      if (dragging_center_) MoveSideways(state, by / pixels_per_img);
      if (dragging_radius_) ScaleRadius(std::exp2(by.x() / kPixelsADoubling));
    }
    mouse_ = moved->at;
    return true;
  }
  return false;
}

}  // namespace ulf::coverage
