// The panels around the live picture. The functions make their texts, the class draws them.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "coverage/operator/palette.h"
#include "coverage/session/capture_state.h"
#include "render/display/plain_panels.h"

namespace ulf::coverage {

// `little_disk_bytes`: free space below this is shown as bad; guessed.
std::vector<render::StatusItem> StatusLine(const CaptureState& state,
                                           std::uint64_t little_disk_bytes = 2'000'000'000);

struct LegendMark {
  render::Rgba color;
  const char* words;
};
std::vector<LegendMark> LegendMarks(const CaptureState& state, const Palette& palette);

// All keys, in the order of the modes.
std::vector<render::TableRow> KeyRows(const render::Rgba& heading);

class Panels : public render::PlainPanels {
 public:
  Panels(render::Painter& painter, const cv::Size& screen, double scale, const Palette& palette)
      : render::PlainPanels(painter, screen, scale), palette_(palette) {}

  void Status(const CaptureState& state) const { render::PlainPanels::Status(StatusLine(state)); }
  void Share(const CaptureState& state) const;
  void TrackingHelp(const CaptureState& state) const;
  void Legend(const CaptureState& state) const;
  void CloseLook(const CaptureState& state) const;
  void Preflight(const CaptureState& state) const;
  void Keys() const { render::PlainPanels::Keys(KeyRows(palette_.guide)); }
  // On both sides of an upright line.
  void BesideLine(const Eigen::Vector2d& top, const std::string& left, const std::string& right) const;

 private:
  const Palette& palette_;
};

}  // namespace ulf::coverage
