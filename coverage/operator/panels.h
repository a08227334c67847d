// Makes the texts of the panels around the live picture, and draws them.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "coverage/operator/overlay.h"
#include "coverage/operator/palette.h"
#include "coverage/session/capture_state.h"
#include "render/display/plain_panels.h"

namespace ulf::coverage {

// The keys and what they do, for the person at the display.
inline constexpr render::KeyHelp kKeysAlways[] = {{"Space", "begin, pause, go on"},
                                                  {"Shift Enter", "begin although a check fails"},
                                                  {"Backspace", "take back the last view"},
                                                  {"S", "subject: place its sphere"},
                                                  {"G", "subject: take the proposed sphere"},
                                                  {"R", "review what is recorded"},
                                                  {"P", "other colours (colour-blind)"},
                                                  {"L", "legend"},
                                                  {"Z", "close look at the map"},
                                                  {"E", "measured errors, or coverage"},
                                                  {"I", "check list"},
                                                  {"M", "sound on leaving the rectangle"},
                                                  {"F or F11", "full screen"},
                                                  {"?", "these keys"},
                                                  {"Q", "finish: closes the light field"}};
inline constexpr render::KeyHelp kKeysInSubject[] = {{"C", "around the middle"},
                                                     {"Up Down wheel", "farther, nearer"},
                                                     {"PgUp PgDn", "in big steps"},
                                                     {"Left Right", "smaller, larger"},
                                                     {"Shift arrows", "across the picture"},
                                                     {"drag", "left moves, right resizes"},
                                                     {"A", "augmented aperture"},
                                                     {"Enter", "take over"},
                                                     {"Esc", "leave as it was"}};
inline constexpr render::KeyHelp kKeysInReview[] = {{"C", "other control"},
                                                    {"arrows, drag", "round the subject"},
                                                    {"PgUp PgDn", "nearer, farther"},
                                                    {"W", "wipe against live"},
                                                    {", .", "move the wipe"},
                                                    {"B", "blink against live"},
                                                    {"D", "stripes where no view is near"},
                                                    {"Delete", "take back the marked view"},
                                                    {"R or Esc", "back"}};

// `little_disk_bytes`: free space below this is shown as bad; guessed.
std::vector<render::StatusItem> StatusLine(const CaptureState& state,
                                           std::uint64_t little_disk_bytes = 2'000'000'000);

struct LegendMark {
  std::optional<render::Rgba> color;  // of the disc before the words; none: there is no disc
  std::string words;
};
std::vector<LegendMark> LegendMarks(const CaptureState& state, const Palette& palette);
// Returns a line for each letter that is on the sphere: "S a surface that ...".
std::vector<std::string> CauseLines(const CaptureState& state);

// The title in the middle and the line below it, while there is no pose; empty: nothing is shown.
struct TitleAndLine {
  std::string title, line;
};
TitleAndLine TrackingTitle(const CaptureState& state);

// Returns all keys, in the order of the modes.
std::vector<render::TableRow> KeyRows(const render::Rgba& heading);

// Draws the panels of one picture of the display. Of each member the name says which panel.
class Panels : public render::PlainPanels {
 public:
  // `screen`: pixels; `scale`: pixels per point; `painter` and `palette` outlive it.
  Panels(render::Painter& painter, const cv::Size& screen, double scale, const Palette& palette)
      : render::PlainPanels(painter, screen, scale), palette_(palette) {}

  void Status(const CaptureState& state) const { render::PlainPanels::Status(StatusLine(state)); }
  void Share(const CaptureState& state) const;
  void TrackingHelp(const CaptureState& state) const;
  void Legend(const CaptureState& state, SphereLayer layer) const;
  void CloseLook(const CaptureState& state) const;
  void Preflight(const CaptureState& state) const;
  void Keys() const { render::PlainPanels::Keys(KeyRows(palette_.guide)); }
  // Writes texts on both sides of a vertical line.
  void BesideLine(const Eigen::Vector2d& top, const std::string& left, const std::string& right) const;

 private:
  const Palette& palette_;
};

}  // namespace ulf::coverage
