#include "coverage/operator/panels.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "core/base/counted.h"

namespace ulf::coverage {
namespace {

using Eigen::Vector2d;

std::string Bytes(std::uint64_t bytes) {
  const double giga = static_cast<double>(bytes) / 1e9;
  return giga < 10 ? fmt::format("{:.1f} GB left", giga) : fmt::format("{:.0f} GB left", giga);
}

std::string Duration(double seconds) {
  constexpr double kMinute = 60, kHour = 3600, kMostHours = 10;
  if (seconds < 1.5 * kMinute)
    return fmt::format("about {:.0f} s left", std::max(5.0, 5 * std::ceil(seconds / 5)));
  if (seconds < 1.5 * kHour) return fmt::format("about {:.0f} min left", std::ceil(seconds / kMinute));
  const double hours = std::ceil(seconds / kHour);
  return hours > kMostHours ? "more than 10 h left" : fmt::format("about {:.0f} h left", hours);
}

}  // namespace

std::vector<render::StatusItem> StatusLine(const CaptureState& state, std::uint64_t little_disk_bytes) {
  std::vector<render::StatusItem> items;
  if (state.frames_per_s) items.push_back({fmt::format("{:.0f} frames/s", *state.frames_per_s)});
  items.push_back({fmt::format("{} dropped", state.dropped),
                   state.dropped > 0 ? render::ink::kCareful : render::ink::kText});
  items.push_back({Counted(state.points.size(), "point")});
  std::string views = Counted(state.view_ids.size(), "view");
  if (state.views_expected) views += fmt::format(" of about {:.0f}", *state.views_expected);
  items.push_back({views});
  if (state.covered) items.push_back({fmt::format("{:.1f} % covered", 100 * *state.covered)});
  if (state.guidance.seconds_left) items.push_back({Duration(*state.guidance.seconds_left)});
  if (state.disk_left_bytes)
    items.push_back({Bytes(*state.disk_left_bytes),
                     *state.disk_left_bytes < little_disk_bytes ? render::ink::kBad : render::ink::kText});
  if (state.exposure_locked)
    items.push_back({*state.exposure_locked ? "exposure locked" : "exposure not locked",
                     *state.exposure_locked ? render::ink::kText : render::ink::kCareful});
  for (const NoticedMistake& noticed : state.mistakes)
    if (noticed.IsSeenAt(state.seconds)) items.push_back({Name(noticed.mistake), render::ink::kCareful});
  if (!state.reopened.empty())
    items.push_back(
        {fmt::format("{} {}",
                     state.reopened_share < 0.01 ? "less than 1 %"
                                                 : fmt::format("{:.0f} %", 100 * state.reopened_share),
                     IsTaken(state.source) ? "is open again" : "must be taken again"),
         render::ink::kCareful});
  if (state.errors) {
    const ErrorSummary errors = Summarize(*state.errors, state.cover.db);
    if (errors.directions > 0)
      items.push_back(
          {fmt::format("picture quality: {} ({:.0f} dB)", QualityInWords(errors.median_db), errors.median_db),
           errors.failing > 0 ? render::ink::kCareful : render::ink::kText});
  }
  if (!state.recording)
    items.push_back({state.waits_to_begin ? "not begun" : "paused", render::ink::kCareful});
  if (!state.device_problem.empty())  // why_waiting contains it
    items.push_back({state.device_problem, render::ink::kBad});
  else if (!state.why_waiting.empty())
    items.push_back({state.why_waiting, render::ink::kBad});
  return items;
}

std::vector<LegendMark> LegendMarks(const CaptureState& state, const Palette& palette) {
  std::vector<LegendMark> marks{{palette.camera, "the camera now"}};
  if (state.guidance.toward) marks.push_back({palette.guide, "where to go next"});
  if (!state.guidance.left_open.empty()) marks.push_back({palette.guide, "dots: you pass these by"});
  if (!state.reopened.empty()) marks.push_back({palette.reopened, "must be taken again"});
  return marks;
}

std::vector<std::string> CauseLines(const CaptureState& state) {
  std::vector<std::string> lines;
  if (!state.errors) return lines;
  for (const auto& [cause, count] : Summarize(*state.errors, state.cover.db).causes)
    if (*LetterOf(cause)) lines.push_back(fmt::format("{}  {} ({})", LetterOf(cause), InWords(cause), count));
  return lines;
}

TitleAndLine TrackingTitle(const CaptureState& state) {
  if (state.tracking == tracking::TrackState::kApart)
    return {"APART", "nothing is recorded until both places are in view"};
  if (state.tracking == tracking::TrackState::kLost) {
    if (!state.turned || !state.turned->reference_has_pose) return {"LOST", ""};
    const std::string way = TurnBackInWords(*state.turned);
    return {"LOST", way.empty() ? "go back to where it was" : way};
  }
  if (IsPureRotation(state.tracking, state.start, state.turned))
    return {"MOVE SIDEWAYS", "the camera only turns"};
  return {"STARTING", ""};
}

std::vector<render::TableRow> KeyRows(const render::Rgba& heading) {
  std::vector<render::TableRow> rows;
  const auto add_keys = [&](std::span<const render::KeyHelp> keys) {
    for (const render::KeyHelp& help : keys) rows.push_back({{}, help.keys, help.what});
  };
  const auto add_heading = [&](const char* mode) {
    rows.push_back({{}, "", ""});
    rows.push_back({{}, mode, "", heading});
  };
  add_keys(kKeysAlways);
  add_heading("placing the subject");
  add_keys(kKeysInSubject);
  add_heading("review");
  add_keys(kKeysInReview);
  return rows;
}

// Large, to be read from an arm's length.
void Panels::Share(const CaptureState& state) const {
  if (!state.coverage || state.view_ids.empty()) return;
  const std::string text = state.covered ? fmt::format("{:.0f} %", std::floor(100 * *state.covered))
                                         : Counted(state.view_ids.size(), "view");
  const Vector2d extent = painter_.Extent(text, render::TextSize::kLarge);
  const Vector2d at(screen_.width - extent.x() - Px(26), Px(46));
  painter_.Box({at.x() - Px(12), at.y() - Px(4), extent.x() + Px(24), extent.y() + Px(8)},
               render::ink::kPanel);
  painter_.Text(at, text, render::TextSize::kLarge,
                state.recorded_view ? palette_.guide : render::ink::kText);
}

void Panels::TrackingHelp(const CaptureState& state) const {
  const bool apart = state.tracking == tracking::TrackState::kApart;
  const bool lost = apart || state.tracking == tracking::TrackState::kLost;
  const auto [title, line] = TrackingTitle(state);
  const Vector2d extent = painter_.Extent(title, render::TextSize::kLarge);
  const Vector2d line_extent = painter_.Extent(line, render::TextSize::kMedium);
  const Vector2d middle(0.5 * screen_.width, 0.42 * screen_.height);
  const double width = std::max({extent.x(), line_extent.x(), Px(260)}) + Px(48);
  const bool bar = state.start && state.start->parallax_needed_deg > 0;
  const double title_height = extent.y() + (line.empty() ? 0 : line_extent.y() + Px(6));
  const double height = title_height + Px(bar ? 58 : 24);
  painter_.Box({middle.x() - 0.5 * width, middle.y() - Px(12), width, height}, render::ink::kPanel, 8);
  painter_.Text({middle.x() - 0.5 * extent.x(), middle.y()}, title, render::TextSize::kLarge,
                lost ? render::ink::kBad : render::ink::kText);
  painter_.Text({middle.x() - 0.5 * line_extent.x(), middle.y() + extent.y() + Px(6)}, line,
                render::TextSize::kMedium, render::ink::kText);
  if (!bar) return;
  // The bar shows the share of the parallax that a first map needs.
  const double share = std::clamp(state.start->parallax_deg / state.start->parallax_needed_deg, 0.0, 1.0);
  const cv::Rect2d whole(middle.x() - 0.5 * width + Px(24), middle.y() + title_height + Px(14),
                         width - Px(48), Px(14));
  painter_.Box(whole, {80, 80, 80}, 3);
  painter_.Box({whole.x, whole.y, share * whole.width, whole.height}, render::ink::kGood, 3);
}

void Panels::Legend(const CaptureState& state, SphereLayer layer) const {
  if (!state.subject || !state.cam_from_world) return;
  const bool of_errors = layer == SphereLayer::kErrors;
  std::vector<LegendMark> marks;
  if (!of_errors) marks = LegendMarks(state, palette_);
  if (of_errors)
    for (const std::string& words : CauseLines(state)) marks.push_back({{}, words});
  const double line = painter_.Extent("X", render::TextSize::kSmall).y() + Px(3), pad = Px(10);
  double width = Px(250);
  for (const LegendMark& mark : marks)
    if (!mark.color)
      width = std::max(width, painter_.Extent(mark.words, render::TextSize::kSmall).x() + 2 * pad);
  const double height = 2 * pad + 2 * line + Px(20) + line * static_cast<double>(marks.size());
  const cv::Rect2d area(Px(12), screen_.height - Px(12) - height, width, height);
  painter_.Box(area, render::ink::kPanel, 6);
  const double x = area.x + pad, inner = width - 2 * pad;
  double y = area.y + pad;
  const auto text = [&](double at_x, const std::string& words) {
    painter_.Text({at_x, y}, words, render::TextSize::kSmall, render::ink::kText);
  };
  text(x, of_errors ? ErrorsInWords(state) : "recorded, against now");
  y += line;
  painter_.Gradient({x, y, 0.5 * inner, Px(16)}, of_errors ? palette_.error_large : palette_.nearer,
                    of_errors ? palette_.error_at_goal : palette_.same);
  painter_.Gradient({x + 0.5 * inner, y, 0.5 * inner, Px(16)},
                    of_errors ? palette_.error_at_goal : palette_.same,
                    of_errors ? palette_.error_small : palette_.farther);
  y += Px(19);
  const std::array names{"nearer", "the same", "farther"};
  for (std::size_t i = 0; i < names.size(); ++i) {
    const double share = 0.5 * static_cast<double>(i);
    const std::string word =
        of_errors ? fmt::format("{:.0f} dB", state.cover.db + (2 * share - 1) * Palette::kErrorReach_db)
                  : names[i];
    text(x + share * (inner - painter_.Extent(word, render::TextSize::kSmall).x()), word);
  }
  y += line;
  for (const LegendMark& mark : marks) {
    if (mark.color) {
      const Vector2d middle(x + Px(8), y + 0.5 * line);
      painter_.Disc(middle, 7, {255, 255, 255});
      painter_.Disc(middle, 5, *mark.color);
    }
    text(mark.color ? x + Px(24) : x, mark.words);
    y += line;
  }
}

void Panels::CloseLook(const CaptureState& state) const {
  constexpr double kWidth = 280, kHeight = 210, kLeast = 1000;  // points
  if (screen_.width < Px(kLeast)) return;
  // In points, so that the drawing keeps its size at any screen density.
  const auto look = MakeCloseLook(state, static_cast<int>(kWidth), static_cast<int>(kHeight), palette_);
  if (!look) return;
  render::Placement placement;
  placement.scale = scale_;
  placement.picture = {double(look->size.x()), double(look->size.y())};
  placement.origin = {screen_.width - Px(kWidth + 12), screen_.height - Px(kHeight + 56)};
  const cv::Rect2d area = placement.Area();
  const cv::Rect2d border(area.x - Px(2), area.y - Px(2), area.width + Px(4), area.height + Px(4));
  painter_.Box(border, {235, 235, 235}, 0);
  painter_.Box(area, {60, 60, 64}, 0);
  painter_.Draw(look->shapes, placement);
}

void Panels::Preflight(const CaptureState& state) const {
  if (state.preflight.empty()) return;
  std::vector<render::TableRow> rows;
  for (const PreflightItem& item : state.preflight) {
    const render::Rgba& failed = item.holds_start ? render::ink::kBad : render::ink::kCareful;
    rows.push_back({!item.in_order   ? render::ink::kDim
                    : *item.in_order ? render::ink::kGood
                                     : failed,
                    item.name, item.words, item.in_order == false ? failed : render::ink::kText});
  }
  Table(rows, {Px(12), Px(46)}, {0, 0}, 420);
}

void Panels::BesideLine(const Vector2d& top, const std::string& left, const std::string& right) const {
  const auto word = [this](const std::string& text, const Vector2d& at) {
    const Vector2d extent = painter_.Extent(text, render::TextSize::kMedium);
    painter_.Box({at.x() - Px(8), at.y() - Px(4), extent.x() + Px(16), extent.y() + Px(8)},
                 render::ink::kPanel);
    painter_.Text(at, text, render::TextSize::kMedium, render::ink::kText);
  };
  const double y = top.y() + Px(48);
  word(left, {top.x() - painter_.Extent(left, render::TextSize::kMedium).x() - Px(20), y});
  word(right, {top.x() + Px(20), y});
}

}  // namespace ulf::coverage
