#include "coverage/operator/operator_display.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "acquisition/counted.h"
#include "acquisition/image.h"

namespace ulf {
namespace {

using Eigen::Vector2d;

const Rgba kText{235, 235, 235}, kDim{170, 170, 170}, kGood{110, 220, 120}, kBad{255, 95, 85},
    kCareful{255, 200, 70}, kPanel{0, 0, 0, 175};

std::string Bytes(std::uint64_t bytes) {
  const double giga = static_cast<double>(bytes) / 1e9;
  return giga < 10 ? fmt::format("{:.1f} GB left", giga) : fmt::format("{:.0f} GB left", giga);
}

std::string Duration(double seconds) {
  if (seconds < 90) return fmt::format("about {:.0f} s left", std::max(5.0, 5 * std::ceil(seconds / 5)));
  return fmt::format("about {:.0f} min left", std::ceil(seconds / 60));
}

struct KeyHelp {
  const char *keys, *what;
};
constexpr KeyHelp kAlways[] = {{"Space", "pause, go on"},
                               {"Backspace", "take back the last view"},
                               {"S", "subject: place its sphere"},
                               {"R", "review what is recorded"},
                               {"P", "other colours (colour-blind)"},
                               {"L", "legend"},
                               {"Z", "close look at the map"},
                               {"I", "check list"},
                               {"M", "sound on leaving the rectangle"},
                               {"F or F11", "full screen"},
                               {"?", "these keys"},
                               {"Q", "finish: closes the light field"}};
constexpr KeyHelp kInSubject[] = {{"C", "around the middle"},
                                  {"Up Down wheel", "farther, nearer"},
                                  {"PgUp PgDn", "in big steps"},
                                  {"Left Right", "smaller, larger"},
                                  {"drag", "left moves, right resizes"},
                                  {"A", "augmented aperture"},
                                  {"Enter", "take over"},
                                  {"Esc", "leave as it was"}};
constexpr KeyHelp kInReview[] = {{"C", "other control"},
                                 {"arrows, drag", "round the subject"},
                                 {"PgUp PgDn", "nearer, farther"},
                                 {"W", "wipe against live"},
                                 {", .", "move the wipe"},
                                 {"B", "blink against live"},
                                 {"R or Esc", "back"}};

}  // namespace

OperatorDisplay::OperatorDisplay(Surface& surface, CaptureFeed& feed, CaptureRequests& requests,
                                 const DisplayOptions& options)
    : surface_(surface),
      feed_(feed),
      requests_(requests),
      review_(options.marker),
      colour_blind_(options.colour_blind) {}

bool OperatorDisplay::Step(double patience_s) {
  for (const InputEvent& event : surface_.TakeEvents(patience_s)) Handle(event);
  TakeStates();
  DrawFrame();
  return !done_;
}

void OperatorDisplay::TakeStates() {
  for (const auto& recorded : feed_.TakeRecorded()) recorded_.Add(*recorded);
  const auto newest = feed_.Newest();
  state_is_new_ = newest && newest != state_;
  if (!state_is_new_) return;
  state_ = newest;
  spread_.Offer(*state_);
  subject_tool_.Follow(*state_);
  if (state_->said != said_) {
    said_ = state_->said;
    said_at_frame_ = frames_;
  }
  const bool held = SubjectIsHeld(*state_).value_or(true);
  if (sound_ && was_held_ && !held) {
    std::fputc('\a', stderr);  // the terminal's bell
    std::fflush(stderr);
  }
  was_held_ = held;
}

// ---- input

void OperatorDisplay::Handle(const InputEvent& event) {
  if (std::holds_alternative<CloseAsked>(event)) {
    requests_.Ask(FinishCapture{});
    done_ = true;
    return;
  }
  if (state_) {
    if (subject_tool_.Handle(event, *state_, placement_.scale, requests_)) return;
    if (review_.Handle(event, *state_)) return;
  }
  HandleInAnyMode(event);
}

bool OperatorDisplay::HandleInAnyMode(const InputEvent& event) {
  if (const auto* key = std::get_if<KeyPressed>(&event)) {
    switch (key->key) {
      case Key::kBackspace:
        requests_.Ask(TakeBackLast{});
        return true;
      case Key::kF11:
        surface_.ToggleFullScreen();
        return true;
      case Key::kF1:
        keys_shown_ = !keys_shown_;
        return true;
      case Key::kEscape:
        keys_shown_ = false;
        return true;
      default:
        return false;
    }
  }
  const auto* typed = std::get_if<Typed>(&event);
  if (!typed) return false;
  switch (typed->character) {
    case '?':
      keys_shown_ = !keys_shown_;
      return true;
    case ' ':
      if (state_) requests_.Ask(SetRecording{!state_->recording});
      return true;
    case 's':
      if (state_) subject_tool_.Open(*state_, requests_);
      return true;
    case 'r':
      if (state_) review_.Open(*state_);
      return true;
    case 'p':
      colour_blind_ = !colour_blind_;
      return true;
    case 'l':
      legend_shown_ = !legend_shown_;
      return true;
    case 'z':
      close_look_shown_ = !close_look_shown_;
      return true;
    case 'i':
      preflight_shown_ = !preflight_shown_.value_or(state_ && state_->view_ids.empty());
      return true;
    case 'm':
      sound_ = !sound_;
      return true;
    case 'f':
      surface_.ToggleFullScreen();
      return true;
    case 'q':
      requests_.Ask(FinishCapture{});
      done_ = true;
      return true;
    default:
      return false;
  }
}

// ---- drawing

void OperatorDisplay::DrawFrame() {
  screen_ = surface_.Size();
  if (screen_.empty()) return;  // a window that is iconified
  ++frames_;
  // Small windows get small text rather than text over text.
  constexpr double kWideEnough = 960, kHighEnough = 540;
  const double fits = std::min(screen_.width / kWideEnough, screen_.height / kHighEnough);
  scale_ = std::clamp(fits, 0.6, surface_.ContentScale());
  scale_ = std::round(scale_ * 20) / 20;  // fonts are made for it
  surface_.Bind();
  painter_.Begin(screen_, scale_);
  constexpr float kDark = 0.07f;
  if (!state_) {
    live_.FillScreen({}, screen_, cv::Vec3f::all(kDark));
    DrawInstruction("waiting for the first frame", kText);
  } else {
    const CaptureState& state = *state_;
    if (state_is_new_ && !state.live.empty()) live_.Upload(Srgb8(state.live));
    placement_ = Placement::Letterboxed(
        state.live.empty() ? cv::Size(state.camera.width, state.camera.height) : state.live.pixels.size(),
        screen_);
    live_.FillScreen(placement_.Area(), screen_, cv::Vec3f::all(kDark));
    if (subject_tool_.is_open())
      DrawSubjectTool(state);
    else if (review_.is_open())
      DrawReview(state);
    else
      DrawLive(state);
    DrawStatus(state);
    DrawSaid();
    if (keys_shown_) DrawKeys();
  }
  surface_.Bind();
  painter_.End();
  surface_.Present();
}

void OperatorDisplay::DrawLive(const CaptureState& state) {
  painter_.Draw(MakeOverlay(state, palette()), placement_);
  DrawShare(state);
  if (preflight_shown_.value_or(state.view_ids.empty())) DrawPreflight(state);
  if (legend_shown_) DrawLegend(state);
  if (close_look_shown_) DrawCloseLook(state);
  DrawHint("? keys");
  if (!state.cam_from_world) DrawTrackingHelp(state);
  const Instruction instruction = InstructionFor(state);
  DrawInstruction(instruction.words, instruction.urgent ? kBad : palette().guide);
}

void OperatorDisplay::DrawSubjectTool(const CaptureState& state) {
  const auto& draft = subject_tool_.draft();
  if (draft && state.cam_from_world) {
    if (subject_tool_.shows_aperture()) {
      constexpr double kWidest = 480;  // all but the subject is blurred anyway
      const double shrink = std::min(1.0, kWidest / state.camera.width);
      const CameraModel camera =
          state.camera.ScaledTo(std::max(1, static_cast<int>(shrink * state.camera.width)),
                                std::max(1, static_cast<int>(shrink * state.camera.height)));
      std::vector<WeightedPicture> pictures;
      for (const PosedPicture& picture : spread_.pictures()) pictures.push_back({&picture, 1});
      const unsigned aperture =
          reprojection_.Draw(camera, *state.cam_from_world, draft->center_in_world, pictures);
      surface_.Bind();
      painter_.Picture(aperture, placement_.Area());
    }
    painter_.Draw(SphereOverlay(state.camera, *state.cam_from_world, *draft, palette().guide), placement_);
  }
  std::vector<Row> rows{{{}, "subject", "", palette().guide}};
  if (draft && state.cam_from_world) {
    const double distance = (state.cam_from_world->OriginInSource() - draft->center_in_world).norm();
    rows.push_back({{}, "distance", fmt::format("{:.3g}", distance)});
    rows.push_back({{}, "radius", fmt::format("{:.3g}", draft->radius)});
  }
  rows.push_back({{},
                  "aperture",
                  subject_tool_.shows_aperture() ? Counted(spread_.pictures().size(), "picture") : "off"});
  for (const KeyHelp& help : kInSubject) rows.push_back({{}, help.keys, help.what, kDim});
  DrawTable(rows, {Px(12), screen_.height - Px(12)}, {0, 1});
  if (!state.cam_from_world)
    DrawTrackingHelp(state);
  else if (!draft)
    DrawInstruction("centre the subject in the picture, then press C", palette().guide);
  else if (subject_tool_.shows_aperture() && spread_.pictures().size() < 4)
    DrawInstruction("move the camera a little: the aperture needs pictures", palette().guide);
}

void OperatorDisplay::DrawReview(const CaptureState& state) {
  if (!state.subject || recorded_.pictures().empty()) {
    DrawInstruction("nothing is recorded yet", palette().guide);
    DrawHint("R back");
    return;
  }
  recorded_.Follow(state);
  const auto virtual_camera = review_.CameraNow(state);
  const bool compares = review_.control() == Review::Control::kLiveCamera;
  constexpr int kBlinkFrames = 15;
  const bool live_turn =
      compares && review_.compare() == Review::Compare::kBlink && frames_ / kBlinkFrames % 2;
  if (virtual_camera && !live_turn) {
    constexpr double kWidest = 640;
    const double shrink = std::min(1.0, kWidest / virtual_camera->camera.width);
    const CameraModel camera = virtual_camera->camera.ScaledTo(
        std::max(1, static_cast<int>(shrink * virtual_camera->camera.width)),
        std::max(1, static_cast<int>(shrink * virtual_camera->camera.height)));
    const unsigned seen =
        reprojection_.Draw(camera, virtual_camera->cam_from_world, state.subject->center_in_world,
                           Review::Nearest(recorded_.pictures(), state.subject->center_in_world,
                                           virtual_camera->cam_from_world));
    surface_.Bind();
    const cv::Rect2d area = placement_.Area();
    if (compares && review_.compare() == Review::Compare::kWipe) {
      const double x = area.x + review_.wipe() * area.width;
      painter_.Box({x, area.y, area.width * (1 - review_.wipe()), area.height}, {0, 0, 0}, 0);
      painter_.PictureRightOf(seen, area, review_.wipe());
      painter_.Line({x, area.y}, {x, area.y + area.height}, 2, palette().guide);
      const double y = area.y + Px(48);
      const Vector2d extent = painter_.Extent("live", TextSize::kMedium);
      painter_.Box({x - extent.x() - Px(28), y - Px(4), extent.x() + Px(16), extent.y() + Px(8)}, kPanel);
      painter_.Text({x - extent.x() - Px(20), y}, "live", TextSize::kMedium, kText);
      const Vector2d right = painter_.Extent("recorded", TextSize::kMedium);
      painter_.Box({x + Px(12), y - Px(4), right.x() + Px(16), right.y() + Px(8)}, kPanel);
      painter_.Text({x + Px(20), y}, "recorded", TextSize::kMedium, kText);
    } else {
      painter_.Box(area, {0, 0, 0}, 0);
      painter_.Picture(seen, area);
    }
  }
  static constexpr const char* kControls[] = {"live camera", "mouse and keys", "marker"};
  std::vector<Row> rows{{{}, "review", Counted(recorded_.pictures().size(), "view"), palette().guide}};
  rows.push_back({{}, "control", kControls[static_cast<int>(review_.control())]});
  for (const KeyHelp& help : kInReview) rows.push_back({{}, help.keys, help.what, kDim});
  DrawTable(rows, {Px(12), screen_.height - Px(12)}, {0, 1});
  if (live_turn) DrawInstruction("live", palette().guide);
  if (!virtual_camera)
    DrawInstruction(review_.control() == Review::Control::kMarker ? "hold the marker before the camera"
                                                                  : "tracking is lost",
                    kBad);
}

void OperatorDisplay::DrawStatus(const CaptureState& state) {
  struct Item {
    std::string text;
    Rgba color = kText;
  };
  std::vector<Item> items;
  if (state.frames_per_s) items.push_back({fmt::format("{:.0f} frames/s", *state.frames_per_s)});
  items.push_back({fmt::format("{} dropped", state.dropped), state.dropped > 0 ? kCareful : kText});
  items.push_back({fmt::format("{} points", state.points.size())});
  std::string views = Counted(state.view_ids.size(), "view");
  if (state.views_expected) views += fmt::format(" of about {:.0f}", *state.views_expected);
  items.push_back({views});
  if (state.covered) items.push_back({fmt::format("{:.1f} % covered", 100 * *state.covered)});
  if (state.guidance.seconds_left) items.push_back({Duration(*state.guidance.seconds_left)});
  constexpr std::uint64_t kLittleDisk = 2'000'000'000;
  if (state.disk_left_bytes)
    items.push_back({Bytes(*state.disk_left_bytes), *state.disk_left_bytes < kLittleDisk ? kBad : kText});
  if (state.exposure_locked)
    items.push_back({*state.exposure_locked ? "exposure locked" : "exposure not locked",
                     *state.exposure_locked ? kText : kCareful});
  if (!state.reopened.empty()) items.push_back({"some fell open again", kCareful});
  if (!state.recording) items.push_back({"paused", kCareful});
  if (!state.waiting_for.empty()) items.push_back({"waiting for " + state.waiting_for, kBad});
  if (!state.device_problem.empty()) items.push_back({state.device_problem, kBad});

  const double gap = Px(22), pad = Px(10), line = painter_.Extent("X", TextSize::kSmall).y() + Px(4);
  std::vector<Vector2d> places;
  double x = pad, y = Px(5);
  for (const Item& item : items) {
    const double width = painter_.Extent(item.text, TextSize::kSmall).x();
    if (x > pad && x + width > screen_.width - pad) x = pad, y += line;
    places.push_back({x, y});
    x += width + gap;
  }
  painter_.Box({0, 0, double(screen_.width), y + line + Px(3)}, kPanel, 0);
  for (std::size_t i = 0; i < items.size(); ++i)
    painter_.Text(places[i], items[i].text, TextSize::kSmall, items[i].color);
}

// The one number that is read from an arm's length.
void OperatorDisplay::DrawShare(const CaptureState& state) {
  if (!state.coverage || state.view_ids.empty()) return;
  const std::string text = state.covered ? fmt::format("{:.0f} %", std::floor(100 * *state.covered))
                                         : Counted(state.view_ids.size(), "view");
  const Vector2d extent = painter_.Extent(text, TextSize::kLarge);
  const Vector2d at(screen_.width - extent.x() - Px(26), Px(46));
  painter_.Box({at.x() - Px(12), at.y() - Px(4), extent.x() + Px(24), extent.y() + Px(8)}, kPanel);
  painter_.Text(at, text, TextSize::kLarge, state.recorded_view ? palette().guide : kText);
}

void OperatorDisplay::DrawTrackingHelp(const CaptureState& state) {
  const bool lost = state.tracking == TrackState::kLost;
  const std::string title = lost ? "LOST" : "STARTING";
  const Vector2d extent = painter_.Extent(title, TextSize::kLarge);
  const Vector2d middle(0.5 * screen_.width, 0.42 * screen_.height);
  const double width = std::max(extent.x(), Px(260)) + Px(48);
  const bool bar = state.start && state.start->parallax_needed_deg > 0;
  const double height = extent.y() + Px(bar ? 58 : 24);
  painter_.Box({middle.x() - 0.5 * width, middle.y() - Px(12), width, height}, kPanel, 8);
  painter_.Text({middle.x() - 0.5 * extent.x(), middle.y()}, title, TextSize::kLarge, lost ? kBad : kText);
  if (!bar) return;
  // How much of the parallax that a map takes is there.
  const double share = std::clamp(state.start->parallax_deg / state.start->parallax_needed_deg, 0.0, 1.0);
  const cv::Rect2d whole(middle.x() - 0.5 * width + Px(24), middle.y() + extent.y() + Px(14), width - Px(48),
                         Px(14));
  painter_.Box(whole, {80, 80, 80}, 3);
  painter_.Box({whole.x, whole.y, share * whole.width, whole.height}, kGood, 3);
}

// What the capture has to say, and what became of what it was asked: long enough to be read.
void OperatorDisplay::DrawSaid() {
  constexpr int kFramesShown = 300;  // about ten seconds
  if (said_.empty() || frames_ - said_at_frame_ > kFramesShown) return;
  const double room = std::min<double>(0.45 * screen_.width, Px(600));  // between the panels
  const Vector2d extent = painter_.Extent(said_, TextSize::kSmall, room);
  const Vector2d at(0.5 * (screen_.width - extent.x()), screen_.height - extent.y() - Px(96));
  painter_.Box({at.x() - Px(10), at.y() - Px(6), extent.x() + Px(20), extent.y() + Px(12)}, kPanel, 6);
  painter_.Text(at, said_, TextSize::kSmall, kCareful, room);
}

void OperatorDisplay::DrawInstruction(const std::string& words, const Rgba& color) {
  if (words.empty()) return;
  // As large as it fits into the room between the panels.
  const double room = std::min<double>(screen_.width - Px(40), Px(900));
  TextSize size = TextSize::kLarge;
  if (painter_.Extent(words, size).x() > room) size = TextSize::kMedium;
  const Vector2d extent = painter_.Extent(words, size, room);
  const Vector2d at(0.5 * (screen_.width - extent.x()), screen_.height - extent.y() - Px(26));
  painter_.Box({at.x() - Px(16), at.y() - Px(6), extent.x() + Px(32), extent.y() + Px(12)}, {0, 0, 0, 200},
               6);
  painter_.Text(at, words, size, color, room);
}

cv::Rect2d OperatorDisplay::DrawTable(const std::vector<Row>& rows, const Vector2d& corner,
                                      const Vector2d& anchor, double wrap_points) {
  const double pad = Px(10), swatch = Px(16), gap = Px(14);
  double left = 0, right = 0, height = 0;
  std::vector<double> heights;
  bool swatches = false;
  for (const Row& row : rows) {
    left = std::max(left, painter_.Extent(row.left, TextSize::kSmall).x());
    const Vector2d extent = painter_.Extent(row.right, TextSize::kSmall, Px(wrap_points));
    right = std::max(right, row.right.empty() ? 0 : extent.x());
    heights.push_back(std::max(extent.y(), painter_.Extent("X", TextSize::kSmall).y()) + Px(3));
    height += heights.back();
    swatches = swatches || row.swatch;
  }
  const double indent = swatches ? swatch + Px(8) : 0;
  const Vector2d size(2 * pad + indent + left + (right > 0 ? gap + right : 0), 2 * pad + height);
  const Vector2d low = corner - anchor.cwiseProduct(size);
  const cv::Rect2d area(low.x(), low.y(), size.x(), size.y());
  painter_.Box(area, kPanel, 6);
  double y = low.y() + pad;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const Row& row = rows[i];
    if (row.swatch) painter_.Box({low.x() + pad, y + Px(2), swatch, swatch}, *row.swatch, 3);
    painter_.Text({low.x() + pad + indent, y}, row.left, TextSize::kSmall, row.color);
    painter_.Text({low.x() + pad + indent + left + gap, y}, row.right, TextSize::kSmall, row.color,
                  Px(wrap_points));
    y += heights[i];
  }
  return area;
}

void OperatorDisplay::DrawLegend(const CaptureState& state) {
  if (!state.subject || !state.cam_from_world) return;
  std::vector<Row> marks;
  marks.push_back({palette().camera, "the camera now"});
  if (state.guidance.toward) marks.push_back({palette().guide, "where to go next"});
  if (!state.reopened.empty()) marks.push_back({palette().reopened, "fell open again"});
  const double line = painter_.Extent("X", TextSize::kSmall).y() + Px(3), pad = Px(10), width = Px(250);
  const double height = 2 * pad + 2 * line + Px(20) + line * static_cast<double>(marks.size());
  const cv::Rect2d area(Px(12), screen_.height - Px(12) - height, width, height);
  painter_.Box(area, kPanel, 6);
  const double x = area.x + pad, inner = width - 2 * pad;
  double y = area.y + pad;
  painter_.Text({x, y}, "recorded, against now", TextSize::kSmall, kText);
  y += line;
  painter_.Gradient({x, y, 0.5 * inner, Px(16)}, palette().nearer, palette().same);
  painter_.Gradient({x + 0.5 * inner, y, 0.5 * inner, Px(16)}, palette().same, palette().farther);
  y += Px(19);
  const auto word = [&](const char* text, double share) {
    const double extent = painter_.Extent(text, TextSize::kSmall).x();
    painter_.Text({x + share * (inner - extent), y}, text, TextSize::kSmall, kText);
  };
  word("nearer", 0), word("the same", 0.5), word("farther", 1);
  y += line;
  for (const Row& mark : marks) {
    const Vector2d middle(x + Px(8), y + 0.5 * line);
    painter_.Disc(middle, 7, {255, 255, 255});
    painter_.Disc(middle, 5, *mark.swatch);
    painter_.Text({x + Px(24), y}, mark.left, TextSize::kSmall, kText);
    y += line;
  }
}

void OperatorDisplay::DrawCloseLook(const CaptureState& state) {
  constexpr double kWidth = 280, kHeight = 210, kLeast = 1000;  // points
  if (screen_.width < Px(kLeast)) return;
  // In points, so that what is drawn on it keeps its size whatever the screen's density.
  const auto look = MakeCloseLook(state, static_cast<int>(kWidth), static_cast<int>(kHeight), palette());
  if (!look) return;
  Placement placement;
  placement.scale = scale_;
  placement.picture = {double(look->size.x()), double(look->size.y())};
  placement.origin = {screen_.width - Px(kWidth + 12), screen_.height - Px(kHeight + 56)};
  const cv::Rect2d area = placement.Area();
  const cv::Rect2d border(area.x - Px(2), area.y - Px(2), area.width + Px(4), area.height + Px(4));
  painter_.Box(border, {235, 235, 235}, 0);
  painter_.Box(area, {60, 60, 64}, 0);
  painter_.Draw(look->shapes, placement);
}

void OperatorDisplay::DrawPreflight(const CaptureState& state) {
  if (state.preflight.empty()) return;
  std::vector<Row> rows;
  for (const PreflightItem& item : state.preflight)
    rows.push_back({!item.in_order   ? kDim
                    : *item.in_order ? kGood
                                     : kBad,
                    item.name, item.words, item.in_order == false ? kBad : kText});
  DrawTable(rows, {Px(12), Px(46)}, {0, 0}, 420);
}

void OperatorDisplay::DrawKeys() {
  std::vector<Row> rows;
  for (const KeyHelp& help : kAlways) rows.push_back({{}, help.keys, help.what});
  rows.push_back({{}, "", ""});
  rows.push_back({{}, "placing the subject", "", palette().guide});
  for (const KeyHelp& help : kInSubject) rows.push_back({{}, help.keys, help.what});
  rows.push_back({{}, "", ""});
  rows.push_back({{}, "review", "", palette().guide});
  for (const KeyHelp& help : kInReview) rows.push_back({{}, help.keys, help.what});
  painter_.Box({0, 0, double(screen_.width), double(screen_.height)}, {0, 0, 0, 150}, 0);
  DrawTable(rows, {0.5 * screen_.width, 0.5 * screen_.height}, {0.5, 0.5});
}

void OperatorDisplay::DrawHint(const std::string& words) {
  const Vector2d extent = painter_.Extent(words, TextSize::kSmall);
  const Vector2d at(screen_.width - extent.x() - Px(22), screen_.height - extent.y() - Px(18));
  painter_.Box({at.x() - Px(10), at.y() - Px(6), extent.x() + Px(20), extent.y() + Px(12)}, kPanel, 6);
  painter_.Text(at, words, TextSize::kSmall, kText);
}

}  // namespace ulf
