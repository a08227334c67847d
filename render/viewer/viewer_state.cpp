#include "render/viewer/viewer_state.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <utility>

#include "core/base/counted.h"

namespace ulf::render {
namespace {

// Effects of a key, a step of the wheel or a drag. All are guessed.
constexpr double kTurnRad = Radians(2);     // an arrow key
constexpr double kDragRad = M_PI;           // a drag over the height of the window
constexpr double kPan = 0.03;               // an arrow key with Shift, in distances to the target
constexpr double kNearer = 1.05;            // PgUp, or a step of the wheel: divides the distance
constexpr double kZoom = 1.05;              // +, or a step of the wheel with Shift
constexpr double kStops = 0.25;             // E
constexpr double kWider = 1.25;             // O, or a step of the wheel with Ctrl: multiplies the aperture
constexpr double kViewerInputWidest = 100;  // the largest aperture, in least apertures
constexpr double kFarther = 1.03;           // U: multiplies the distance of the focus
constexpr double kStillPx = 4;              // a press that moves less is a click

// Skips fields that take a software rasteriser seconds: they have their own keys.
FieldKind NextField(FieldKind kind) {
  auto next = std::ranges::find(kViewerFields, kind);
  do {
    if (++next == std::end(kViewerFields)) next = std::begin(kViewerFields);
  } while (*next == FieldKind::kLumigraphPerPixel || *next == FieldKind::kSoft);
  return *next;
}

void Toggle(bool& flag) { flag = !flag; }

}  // namespace

std::optional<Aperture> ViewerState::OpenAperture() const {
  if (!(aperture > 0)) return std::nullopt;
  return Aperture{.radius = aperture, .focus_in_world = focus_in_world};
}

std::vector<ViewerRequest> ViewerInput::TakeRequests() { return std::exchange(requests_, {}); }

void ViewerInput::Handle(const InputEvent& event, const cv::Size& screen) {
  if (std::holds_alternative<CloseAsked>(event)) return Request(ViewerRequest::kLeave);
  if (const auto* key = std::get_if<KeyPressed>(&event)) return Press(*key);
  if (const auto* typed = std::get_if<Typed>(&event)) return Type(typed->character, screen);
  if (const auto* wheel = std::get_if<WheelTurned>(&event)) return Turn(*wheel);
  if (const auto* button = std::get_if<MouseButton>(&event)) return Click(*button);
  if (const auto* moved = std::get_if<MouseMoved>(&event)) Move(moved->at, screen);
}

void ViewerInput::Turn(const WheelTurned& wheel) {
  if (wheel.control) return Widen(wheel.steps);
  state_.camera = wheel.shift ? Zoomed(state_.camera, std::pow(kZoom, wheel.steps))
                              : MovedIn(state_.camera, std::pow(kNearer, wheel.steps));
}

void ViewerInput::Click(const MouseButton& button) {
  if (button.down) {
    pressed_ = button.button;
    pressed_at_ = mouse_;
    dragging_ = false;
    return;
  }
  if (pressed_ == button.button && button.button == 0 && !dragging_) Request(ViewerRequest::kFocus, mouse_);
  pressed_.reset();
}

void ViewerInput::Move(const Eigen::Vector2d& to, const cv::Size& screen) {
  if (pressed_ && dragging_) Drag(to - mouse_, screen);
  if (pressed_ && !dragging_ && (to - pressed_at_).norm() >= kStillPx) {
    dragging_ = true;
    Drag(to - pressed_at_, screen);
  }
  mouse_ = to;
}

// The point under the mouse follows it.
void ViewerInput::Drag(const Eigen::Vector2d& by, const cv::Size& screen) {
  if (screen.empty()) return;
  if (*pressed_ == 0) {
    const double turn = kDragRad / screen.height;
    state_.camera = Orbited(state_.camera, -turn * by.x(), turn * by.y());
  } else {
    const double focal_px = state_.camera.ModelFor(screen).fx;
    state_.camera = Panned(state_.camera, -by.x() / focal_px, by.y() / focal_px);
  }
}

// An aperture is closed, or at least the least aperture.
void ViewerInput::Widen(double steps) {
  constexpr double kRounding = 0.99;  // of the least aperture, after steps out and back
  const double wider = std::max(state_.aperture, least_aperture_ / kWider) * std::pow(kWider, steps);
  state_.aperture =
      wider < kRounding * least_aperture_ ? 0 : std::min(wider, kViewerInputWidest * least_aperture_);
}

void ViewerInput::FocusFarther(double steps) {
  const Eigen::Vector3d& eye = state_.camera.eye_in_world;
  state_.focus_in_world = eye + std::pow(kFarther, steps) * (state_.focus_in_world - eye);
}

void ViewerInput::Open(const Aperture& aperture) {
  state_.aperture = aperture.radius;
  state_.focus_in_world = aperture.focus_in_world;
}

void ViewerInput::Press(const KeyPressed& key) {
  const auto move = [&](double right, double up) {
    state_.camera = key.shift ? Panned(state_.camera, kPan * right, kPan * up)
                              : Orbited(state_.camera, kTurnRad * right, kTurnRad * up);
  };
  switch (key.key) {
    case Key::kLeft:
      return move(-1, 0);
    case Key::kRight:
      return move(1, 0);
    case Key::kUp:
      return move(0, 1);
    case Key::kDown:
      return move(0, -1);
    case Key::kPageUp:
      state_.camera = MovedIn(state_.camera, kNearer);
      return;
    case Key::kPageDown:
      state_.camera = MovedIn(state_.camera, 1 / kNearer);
      return;
    case Key::kHome:
      state_.camera = start_;
      return;
    case Key::kF1:
      return Toggle(state_.shows_keys);
    case Key::kEscape:
      state_.shows_keys = false;
      return;
    case Key::kF11:
      return Request(ViewerRequest::kFullScreen);
    default:
      return;
  }
}

void ViewerInput::Type(char32_t character, const cv::Size& screen) {
  if (character >= U'A' && character <= U'Z') character += U'a' - U'A';  // also with Caps Lock
  if (character >= U'1' && character <= U'6') {
    state_.field.kind = kViewerFields[character - U'1'];
    return;
  }
  static const std::map<char32_t, bool ViewerState::*> kToggles{
      {U'b', &ViewerState::shows_field}, {U'm', &ViewerState::shows_mesh},  {U'w', &ViewerState::shows_gizmo},
      {U'c', &ViewerState::shows_doubt}, {U't', &ViewerState::shows_texts}, {U'?', &ViewerState::shows_keys}};
  static const std::map<char32_t, ViewerRequest::What> kRequests{{U'n', ViewerRequest::kNearestView},
                                                                 {U's', ViewerRequest::kScreenshot},
                                                                 {U'k', ViewerRequest::kKeyframe},
                                                                 {U'g', ViewerRequest::kFullScreen},
                                                                 {U'q', ViewerRequest::kLeave}};
  if (const auto toggle = kToggles.find(character); toggle != kToggles.end())
    return Toggle(state_.*toggle->second);
  if (const auto request = kRequests.find(character); request != kRequests.end())
    return Request(request->second);
  switch (character) {
    case 'f':
      state_.field.kind = NextField(state_.field.kind);
      return;
    case 'l':
      state_.field.level = state_.field.kind == FieldKind::kSubdivision
                               ? state_.field.level % kFinestLevel + 1
                               : state_.field.level;
      state_.field.kind = FieldKind::kSubdivision;
      return;
    case 'p':
      state_.proxy = (state_.proxy + 1) % proxies_;
      return;
    case '+':
    case '=':  // the same key without Shift
      state_.camera = Zoomed(state_.camera, kZoom);
      return;
    case '-':
      state_.camera = Zoomed(state_.camera, 1 / kZoom);
      return;
    case 'e':
      state_.exposure_stops += kStops;
      return;
    case 'd':
      state_.exposure_stops -= kStops;
      return;
    case 'o':
      return Widen(1);
    case 'i':
      return Widen(-1);
    case 'x':
      if (state_.aperture > 0)
        last_aperture_ = std::exchange(state_.aperture, 0);
      else
        state_.aperture = std::max(last_aperture_, least_aperture_);
      return;
    case 'u':
      return FocusFarther(1);
    case 'j':
      return FocusFarther(-1);
    case 'r':
      return Request(ViewerRequest::kFocus, {0.5 * screen.width, 0.5 * screen.height});
    default:
      return;
  }
}

std::vector<StatusItem> StatusLine(const ViewerState& state, const ViewerFigures& figures) {
  std::vector<StatusItem> items;
  const bool as_asked = figures.field.kind == state.field.kind;
  items.push_back(
      {FieldText(figures.field) +
           (as_asked ? "" : fmt::format(" ({} is not possible here)", FieldName(state.field.kind))),
       as_asked ? ink::kText : ink::kCareful});
  if (state.aperture > 0) {
    const bool widens = UsesMesh(figures.field.kind);
    items.push_back({fmt::format("aperture {:.3g}{}, focus {:.3g}{}", state.aperture,
                                 figures.f_number ? fmt::format(" (f/{:.2g})", *figures.f_number) : "",
                                 figures.focus_depth, widens ? "" : ": this field has no rings to widen"),
                     widens ? ink::kText : ink::kCareful});
  } else {
    items.push_back({"proxy " + figures.proxy});
  }
  items.push_back({Counted(figures.views, "view")});
  if (state.camera.zoom != 1) items.push_back({fmt::format("zoom {:.2f}", state.camera.zoom)});
  if (state.exposure_stops != 0) items.push_back({fmt::format("{:+.2f} stops", state.exposure_stops)});
  if (figures.loading) items.push_back({"reading photographs", ink::kCareful});
  if (!figures.drawn_size.empty())
    items.push_back(
        {fmt::format("drawn at {}x{} while it moves", figures.drawn_size.width, figures.drawn_size.height)});
  if (figures.frame_ms > 0)
    items.push_back(
        {fmt::format("{:.1f} ms a frame, {:.1f} the light field; {:.{}f} frames/s", figures.frame_ms,
                     figures.picture_ms, 1000 / figures.frame_ms, figures.frame_ms > 100 ? 1 : 0)});
  return items;
}

}  // namespace ulf::render
