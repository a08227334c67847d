#include "coverage/operator/operator_display.h"

#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <span>
#include <utility>

#include "core/base/counted.h"
#include "core/image/image.h"
#include "coverage/operator/instruction.h"
#include "coverage/operator/key_actions.h"

namespace ulf::coverage {
namespace {

// All guessed.
// How long a message of the capture stays on the screen, and the failed checks after a first view that came
// at once; less is too short to read.
constexpr double kDisplayToRead_s = 10;
// A key takes back only a view marked for so long: nobody can mean one that was marked just now.
constexpr double kDisplayToSee_s = 0.5;
constexpr std::size_t kDisplayLinesAtOnce = 3;  // messages of the capture; older ones disappear
// The window's frame flashes so long when the subject leaves the safety rectangle.
constexpr double kDisplayFlash_s = 0.4;
// Review: how long the live picture and the recorded one are shown in turn.
constexpr double kDisplayBlink_s = 0.5;
// The augmented aperture is drawn no wider, in pixels: all but the subject is blurred anyway. So is the
// review, whose pictures are no wider (PosedPicture::kLongerSide).
constexpr double kDisplayApertureWidth_px = 480, kDisplayReviewWidth_px = 640;
// Fewer show hardly any blur: the person is asked to move.
constexpr std::size_t kDisplayAperturePictures = 4;

double SteadySeconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

CameraModel NoWiderThan(double width_px, const CameraModel& camera) {
  const double shrink = std::min(1.0, width_px / camera.width);
  return camera.ScaledTo(std::max(1, static_cast<int>(shrink * camera.width)),
                         std::max(1, static_cast<int>(shrink * camera.height)));
}

// ": what is wrong", where something is.
std::string CauseHere(const ErrorMap::Part& part) {
  return part.frame.cause == render::ErrorCause::kNone ? "" : fmt::format(": {}", InWords(part.frame.cause));
}

void AddKeys(std::span<const render::KeyHelp> keys, std::vector<render::TableRow>& rows) {
  for (const render::KeyHelp& help : keys) rows.push_back({{}, help.keys, help.what, render::ink::kDim});
}

}  // namespace

OperatorDisplay::OperatorDisplay(render::Surface& surface, CaptureFeed& feed, CaptureRequests& requests,
                                 const DisplayOptions& options)
    : surface_(surface), feed_(feed), options_(options), pending_(requests), review_(options.marker) {}

bool OperatorDisplay::Step(double patience_s) {
  now_s_ = options_.clock_s ? options_.clock_s() : SteadySeconds();
  for (const render::InputEvent& event : surface_.TakeEvents(patience_s)) Handle(event);
  TakeStates();
  DrawFrame();
  return !done_;
}

void OperatorDisplay::TakeStates() {
  const auto newest = feed_.Newest();
  state_is_new_ = newest && newest != state_;
  if (state_is_new_) state_ = newest;
  if (!state_) return;
  recorded_.Follow(*state_);
  if (const auto problem = recorded_.TakeProblem()) Say(*problem);
  if (!state_is_new_) return;
  spread_.Offer(*state_);
  subject_tool_.Follow(*state_, pending_);
  const std::uint64_t fresh = std::min<std::uint64_t>(
      state_->times_said - std::exchange(times_said_, state_->times_said), state_->said.size());
  for (auto line = state_->said.end() - static_cast<std::ptrdiff_t>(fresh); line != state_->said.end();
       ++line)
    Say(*line);
  // Failed checks stay long enough to read, also where the first view came at once.
  if (!std::exchange(preflight_seen_, !state_->preflight.empty() || preflight_seen_) && preflight_seen_ &&
      std::ranges::any_of(state_->preflight,
                          [](const PreflightItem& item) { return item.in_order == false; }))
    preflight_until_s_ = now_s_ + kDisplayToRead_s;
  const bool in_rectangle = IsSubjectInRectangle(*state_).value_or(true);
  if (was_in_rectangle_ && !in_rectangle) {
    flash_until_s_ = now_s_ + kDisplayFlash_s;
    if (sound_) {
      std::fputc('\a', stderr);  // the terminal's bell
      std::fflush(stderr);
    }
  }
  was_in_rectangle_ = in_rectangle;
}

void OperatorDisplay::Say(const std::string& words) {
  std::erase_if(said_, [&](const Said& earlier) { return earlier.words == words; });
  said_.push_back({words, now_s_});
  if (said_.size() > kDisplayLinesAtOnce) said_.pop_front();
}

bool OperatorDisplay::ShowFinalState() {
  over_ = true;
  TakeStates();
  return state_ && state_->ended == StoppedBecause::kCovered;
}

bool OperatorDisplay::Detach() {
  if (subject_tool_.is_open()) subject_tool_.Close(pending_);
  const bool nobody_has_begun = !state_ || state_->waits_to_begin;
  if (nobody_has_begun) pending_.BeginAlthoughChecksFail();
  return nobody_has_begun || pending_.Records(*state_);
}

// ---- input

void OperatorDisplay::Finish() {
  pending_.Finish();
  done_ = true;
}

void OperatorDisplay::Handle(render::InputEvent event) {
  if (auto* typed = std::get_if<render::Typed>(&event))  // Caps Lock has no effect
    if (typed->character >= U'A' && typed->character <= U'Z') typed->character += U'a' - U'A';
  if (over_) {
    const auto* button = std::get_if<render::MouseButton>(&event);
    if (std::holds_alternative<render::KeyPressed>(event) || std::holds_alternative<render::Typed>(event) ||
        std::holds_alternative<render::CloseAsked>(event) || (button && button->down))
      done_ = true;
    return;
  }
  if (std::holds_alternative<render::CloseAsked>(event)) return Finish();
  if (state_) {
    if (subject_tool_.Handle(event, *state_, placement_.scale, pending_)) return;
    if (review_.is_open() && (HandleTakeBack(event) || HandleStripes(event))) return;
    if (review_.Handle(event, *state_)) return;
  }
  if (const auto* key = std::get_if<render::KeyPressed>(&event)) Press(*key);
  if (const auto* typed = std::get_if<render::Typed>(&event)) Type(typed->character);
}

bool OperatorDisplay::HandleStripes(const render::InputEvent& event) {
  const auto* typed = std::get_if<render::Typed>(&event);
  if (!typed || typed->character != U'd') return false;
  rendered_.SetHatchesDoubt(!rendered_.hatches_doubt());
  return true;
}

bool OperatorDisplay::HandleTakeBack(const render::InputEvent& event) {
  const auto* key = std::get_if<render::KeyPressed>(&event);
  if (!key || (key->key != render::Key::kDelete && key->key != render::Key::kBackspace)) return false;
  if (!marked_view_) return true;
  if (now_s_ - marked_at_s_ < kDisplayToSee_s) {
    Say(fmt::format("view {} was marked only just now: press again to take it back", *marked_view_));
  } else {
    pending_.TakeBack(*std::exchange(marked_view_, std::nullopt));
  }
  return true;
}

void OperatorDisplay::Press(const render::KeyPressed& pressed) {
  if (pressed.key == render::Key::kEnter && state_ && state_->waits_to_begin)
    return pressed.shift ? pending_.BeginAlthoughChecksFail() : pending_.Record(true);
  const render::Key key = pressed.key;
  RunAction(key, {{render::Key::kBackspace, [&] { TakeBackLast(); }},
                  {render::Key::kF11, [&] { surface_.ToggleFullScreen(); }},
                  {render::Key::kF1, [&] { keys_shown_ = !keys_shown_; }},
                  {render::Key::kEscape, [&] { keys_shown_ = false; }}});
}

void OperatorDisplay::Type(char32_t character) {
  if (state_ && RunAction(character, {{U' ', [&] { pending_.Record(!pending_.Records(*state_)); }},
                                      {U's', [&] { subject_tool_.Open(*state_, pending_); }},
                                      {U'g', [&] { TakeProposedSubject(); }},
                                      {U'r', [&] { review_.Open(*state_); }}}))
    return;
  const bool before_first_view = state_ && state_->view_ids.empty();
  RunAction(character, {{U'?', [&] { keys_shown_ = !keys_shown_; }},
                        {U'p', [&] { colour_blind_ = !colour_blind_; }},
                        {U'l', [&] { legend_shown_ = !legend_shown_; }},
                        {U'e', [&] { ShowOtherLayer(); }},
                        {U'z', [&] { close_look_shown_ = !close_look_shown_; }},
                        {U'i', [&] { preflight_shown_ = !preflight_shown_.value_or(before_first_view); }},
                        {U'm', [&] { sound_ = !sound_; }},
                        {U'f', [&] { surface_.ToggleFullScreen(); }},
                        {U'q', [&] { Finish(); }}});
}

void OperatorDisplay::ShowOtherLayer() {
  layer_ = layer_ == SphereLayer::kErrors ? SphereLayer::kCoverage : SphereLayer::kErrors;
  if (layer_ == SphereLayer::kErrors && state_ && !state_->errors)
    Say("no errors are measured yet: they need geometry, which begins with some ten views");
}

void OperatorDisplay::TakeProposedSubject() {
  if (state_->proposed_subject)
    pending_.Place(*state_->proposed_subject);
  else
    Say("no other sphere is proposed");
}

void OperatorDisplay::TakeBackLast() {
  const auto view = state_ ? pending_.LastView(*state_) : std::nullopt;
  if (view) pending_.TakeBack(*view);
}

// ---- drawing

void OperatorDisplay::DrawFrame() {
  const cv::Size screen = surface_.Size();
  if (screen.empty()) return;  // an iconified window
  const double scale = ScaleOf(surface_);
  surface_.Bind();
  painter_.Begin(screen, scale);
  const Panels panels(painter_, screen, scale, palette());
  constexpr float kDark = 0.07f;
  if (!state_) {
    live_.FillScreen({}, screen, cv::Vec3f::all(kDark));
    panels.Instruction("waiting for the first frame", render::ink::kText);
  } else {
    const CaptureState& state = *state_;
    if (state_is_new_ && !state.live.empty()) live_.Upload(Srgb8(state.live));
    placement_ = render::Placement::Letterboxed(
        state.live.empty() ? cv::Size(state.camera.width, state.camera.height) : state.live.pixels.size(),
        screen);
    live_.FillScreen(placement_.Area(), screen, cv::Vec3f::all(kDark));
    const auto marked_before = std::exchange(marked_view_, std::nullopt);
    if (subject_tool_.is_open() && !state.ended)
      DrawSubjectTool(state, panels);
    else if (review_.is_open() && !state.ended)
      DrawReview(state, panels);
    else
      DrawLive(state, panels);
    if (!review_.is_open()) rendered_.Close();
    if (marked_view_ != marked_before) marked_at_s_ = now_s_;
    if (now_s_ < flash_until_s_) panels.Flash(palette().alarm);
    panels.Status(state);
    std::erase_if(said_, [&](const Said& said) { return now_s_ - said.at_s > kDisplayToRead_s; });
    std::string lines;
    for (const Said& said : said_) lines += (lines.empty() ? "" : "\n") + said.words;
    if (!lines.empty()) panels.Notice(lines);
    if (keys_shown_) panels.Keys();
  }
  surface_.Bind();
  painter_.End();
  surface_.Present();
}

void OperatorDisplay::DrawLive(const CaptureState& state, const Panels& panels) {
  painter_.Draw(MakeOverlay(state, palette(), layer_), placement_);
  panels.Share(state);
  if (preflight_shown_.value_or(state.view_ids.empty() || now_s_ < preflight_until_s_))
    panels.Preflight(state);
  if (legend_shown_) panels.Legend(state, layer_);
  if (close_look_shown_) panels.CloseLook(state);
  panels.Hint(over_ ? "closed: any key" : state.ended ? "closing the light field" : "? keys");
  if (!state.cam_from_world && !state.ended) panels.TrackingHelp(state);
  const Instruction instruction = InstructionFor(state);
  panels.Instruction(InWords(instruction, state), instruction.urgent ? render::ink::kBad : palette().guide);
}

void OperatorDisplay::DrawSubjectTool(const CaptureState& state, const Panels& panels) {
  const auto& draft = subject_tool_.draft();
  if (draft && state.cam_from_world) {
    if (subject_tool_.shows_aperture()) {
      const unsigned aperture =
          reprojection_.Draw(NoWiderThan(kDisplayApertureWidth_px, state.camera), *state.cam_from_world,
                             draft->center_in_world, spread_.pictures());
      surface_.Bind();
      painter_.Picture(aperture, placement_.Area());
    }
    painter_.Draw(SphereOverlay(state.camera, *state.cam_from_world, *draft, palette().guide), placement_);
  }
  std::vector<render::TableRow> rows{{{}, "subject", "", palette().guide}};
  if (draft && state.cam_from_world) {
    const double distance = (state.cam_from_world->OriginInSource() - draft->center_in_world).norm();
    rows.push_back({{}, "distance", fmt::format("{:.3g}", distance)});
    rows.push_back({{}, "radius", fmt::format("{:.3g}", draft->radius)});
  }
  rows.push_back({{},
                  "aperture",
                  subject_tool_.shows_aperture() ? Counted(spread_.pictures().size(), "picture") : "off"});
  AddKeys(kKeysInSubject, rows);
  panels.Mode(rows);
  if (!state.cam_from_world)
    panels.TrackingHelp(state);
  else if (!draft)
    panels.Instruction(IsTaken(state.source) ? "press C while the subject is in the middle of the picture"
                                             : "centre the subject in the picture, then press C",
                       palette().guide);
  else if (subject_tool_.shows_aperture() && spread_.pictures().size() < kDisplayAperturePictures)
    panels.Instruction(IsTaken(state.source) ? "the aperture needs more pictures"
                                             : "move the camera a little: the aperture needs pictures",
                       palette().guide);
}

// Draws by the renderer or, until it can, by the nearest pictures over one plane.
unsigned OperatorDisplay::PictureInReview(const CaptureState& state,
                                          const Review::VirtualCamera& virtual_camera) {
  const CameraModel camera = NoWiderThan(kDisplayReviewWidth_px, virtual_camera.camera);
  rendered_.Follow(state, now_s_);
  if (const auto problem = rendered_.TakeProblem()) Say(*problem);
  const auto rendered = rendered_.Draw(camera, virtual_camera.cam_from_world);
  is_rendered_ = rendered.has_value();
  if (rendered) return *rendered;
  return reprojection_.Draw(camera, virtual_camera.cam_from_world, state.subject->center_in_world,
                            recorded_.Nearest(state, virtual_camera.cam_from_world));
}

std::vector<render::TableRow> OperatorDisplay::ReviewRows(
    const CaptureState& state, const std::optional<Review::VirtualCamera>& virtual_camera) const {
  static constexpr const char* kControls[] = {"live camera", "mouse and keys", "marker"};
  std::vector<render::TableRow> rows{{{}, "review", Counted(state.view_ids.size(), "view"), palette().guide}};
  if (!is_rendered_) {
    rows.push_back({{}, "preview", "nearest pictures, on a plane"});
    if (recorded_.missing() > 0) rows.push_back({{}, "reading", Counted(recorded_.missing(), "picture")});
  } else {
    rows.push_back({{}, "rendered", MeshInWords(state)});
    if (rendered_.is_loading()) rows.push_back({{}, "reading", "newer photographs"});
    if (rendered_.hatches_doubt()) rows.push_back({{}, "stripes", "no view is near: a gap"});
  }
  if (virtual_camera && state.errors)
    if (const ErrorMap::Part* here = state.errors->At(virtual_camera->cam_from_world.OriginInSource() -
                                                      state.subject->center_in_world))
      rows.push_back({{},
                      "measured",
                      fmt::format("{} here ({:.0f} dB){}", QualityInWords(here->DbNow()), here->DbNow(),
                                  CauseHere(*here))});
  rows.push_back({{}, "control", kControls[static_cast<int>(review_.control())]});
  rows.push_back({{}, "marked", marked_view_ ? fmt::format("view {}", *marked_view_) : "none"});
  AddKeys(kKeysInReview, rows);
  return rows;
}

void OperatorDisplay::DrawReview(const CaptureState& state, const Panels& panels) {
  if (!state.subject || state.view_ids.empty()) {
    panels.Instruction("nothing is recorded yet", palette().guide);
    panels.Hint("R back");
    return;
  }
  const auto virtual_camera = review_.CameraNow(state);
  const bool compares = review_.control() == Review::Control::kLiveCamera;
  const bool live_turn = compares && review_.compare() == Review::Compare::kBlink &&
                         static_cast<long>(now_s_ / kDisplayBlink_s) % 2 != 0;
  if (virtual_camera && !live_turn) {
    const unsigned seen = PictureInReview(state, *virtual_camera);
    surface_.Bind();
    const cv::Rect2d area = placement_.Area();
    if (compares && review_.compare() == Review::Compare::kWipe) {
      const double x = area.x + review_.wipe() * area.width;
      painter_.Box({x, area.y, area.width * (1 - review_.wipe()), area.height}, {0, 0, 0}, 0);
      painter_.PictureRightOf(seen, area, review_.wipe());
      painter_.Line({x, area.y}, {x, area.y + area.height}, 2, palette().guide);
      panels.BesideLine({x, area.y}, "live", "recorded");
    } else {
      painter_.Box(area, {0, 0, 0}, 0);
      painter_.Picture(seen, area);
    }
  }
  if (virtual_camera) {
    const auto mark =
        MarkNearestView(state, pending_, virtual_camera->camera, virtual_camera->cam_from_world, palette());
    if (mark) {
      marked_view_ = mark->id;
      painter_.Draw(mark->shapes, placement_);
    }
  }
  panels.Mode(ReviewRows(state, virtual_camera));
  if (live_turn) panels.Instruction("live", palette().guide);
  if (review_.control() == Review::Control::kMarker && !review_.marker_is_seen())
    panels.Instruction("hold the marker before the camera", render::ink::kBad);
  else if (!virtual_camera)
    panels.Instruction("tracking is lost", render::ink::kBad);
}

}  // namespace ulf::coverage
