#include "render/viewer/viewer_state.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

namespace ulf::render {
namespace {

constexpr double kDegree = M_PI / 180;
constexpr double kTurn = 2 * kDegree, kStep = 0.03, kNearer = 1.05, kCloser = 1.05;  // of a key
constexpr double kTurnOfHeight = M_PI;  // of a drag as long as the window is high
constexpr double kStops = 0.25;
constexpr double kWider = 1.25, kFarther = 1.03;
constexpr double kWidest = 100;     // least apertures
constexpr double kStillPixels = 4;  // a click's

// Weights of all views at every pixel take a software rasteriser seconds: they have a key of their own.
FieldKind NextField(FieldKind kind) {
  const auto at = std::find(std::begin(kViewerFields), std::end(kViewerFields), kind);
  const auto next = std::next(at) == std::end(kViewerFields) ? std::begin(kViewerFields) : std::next(at);
  return *next == FieldKind::kLumigraphPerPixel ? *std::next(next) : *next;
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
  state_.camera = wheel.shift ? Zoomed(state_.camera, std::pow(kCloser, wheel.steps))
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
  if (pressed_ && !dragging_ && (to - pressed_at_).norm() >= kStillPixels) {
    dragging_ = true;
    Drag(to - pressed_at_, screen);
  }
  mouse_ = to;
}

// What is under the mouse follows it.
void ViewerInput::Drag(const Eigen::Vector2d& by, const cv::Size& screen) {
  if (screen.empty()) return;
  if (*pressed_ == 0) {
    const double turn = kTurnOfHeight / screen.height;
    state_.camera = Orbited(state_.camera, -turn * by.x(), turn * by.y());
  } else {
    const double focal_px = state_.camera.For(screen).fx;
    state_.camera = Panned(state_.camera, -by.x() / focal_px, by.y() / focal_px);
  }
}

// Everything between closed and the least does nothing.
void ViewerInput::Widen(double steps) {
  const double wider = std::max(state_.aperture, least_aperture_ / kWider) * std::pow(kWider, steps);
  state_.aperture = wider < 0.99 * least_aperture_ ? 0 : std::min(wider, kWidest * least_aperture_);
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
    state_.camera = key.shift ? Panned(state_.camera, kStep * right, kStep * up)
                              : Orbited(state_.camera, kTurn * right, kTurn * up);
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
  if (character >= U'A' && character <= U'Z') character += U'a' - U'A';  // whatever Caps Lock says
  if (character >= U'1' && character <= U'5') {
    state_.field.kind = kViewerFields[character - U'1'];
    return;
  }
  switch (character) {
    case 'f':
      state_.field.kind = NextField(state_.field.kind);
      return;
    case 'l':
      state_.field.level = state_.field.kind == FieldKind::kSubdivision ? state_.field.level % kLimitLevel + 1
                                                                        : state_.field.level;
      state_.field.kind = FieldKind::kSubdivision;
      return;
    case 'p':
      state_.proxy = (state_.proxy + 1) % proxies_;
      return;
    case 'b':
      return Toggle(state_.shows_field);
    case 'm':
      return Toggle(state_.shows_mesh);
    case 'w':
      return Toggle(state_.shows_where);
    case 'c':
      return Toggle(state_.shows_doubt);
    case 't':
      return Toggle(state_.shows_words);
    case '?':
      return Toggle(state_.shows_keys);
    case '+':
    case '=':  // the same key without Shift
      state_.camera = Zoomed(state_.camera, kCloser);
      return;
    case '-':
      state_.camera = Zoomed(state_.camera, 1 / kCloser);
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
    case 'n':
      return Request(ViewerRequest::kNearestView);
    case 's':
      return Request(ViewerRequest::kScreenshot);
    case 'k':
      return Request(ViewerRequest::kKeyframe);
    case 'g':
      return Request(ViewerRequest::kFullScreen);
    case 'q':
      return Request(ViewerRequest::kLeave);
    default:
      return;
  }
}

}  // namespace ulf::render
