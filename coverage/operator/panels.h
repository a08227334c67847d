// What stands around the live picture: words, numbers and tables on dark ground. What is said is made apart
// from drawing it; drawing keeps nothing from one frame to the next.
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "coverage/capture_state.h"
#include "coverage/operator/painter.h"
#include "coverage/operator/palette.h"

namespace ulf {

namespace ink {
inline constexpr Rgba kText{235, 235, 235}, kDim{170, 170, 170}, kGood{110, 220, 120}, kBad{255, 95, 85},
    kCareful{255, 200, 70};
}

// One of the status line's, from left to right.
struct StatusItem {
  std::string text;
  Rgba color = ink::kText;
};
std::vector<StatusItem> StatusLine(const CaptureState& state);

struct LegendMark {
  Rgba color;
  const char* words;
};
std::vector<LegendMark> LegendMarks(const CaptureState& state, const Palette& palette);

struct TableRow {
  std::optional<Rgba> swatch;
  std::string left = {}, right = {};
  Rgba color = ink::kText;
};
// All keys, in the order of the modes.
std::vector<TableRow> KeyRows(const Rgba& heading);

// On one frame: `scale` pixels a point.
class Panels {
 public:
  Panels(Painter& painter, const cv::Size& screen, double scale, const Palette& palette)
      : painter_(painter), screen_(screen), scale_(scale), palette_(palette) {}

  void Status(const CaptureState& state) const;
  void Share(const CaptureState& state) const;
  void TrackingHelp(const CaptureState& state) const;
  void Said(const std::string& words) const;
  void Instruction(const std::string& words, const Rgba& color) const;
  void Legend(const CaptureState& state) const;
  void CloseLook(const CaptureState& state) const;
  void Preflight(const CaptureState& state) const;
  void Keys() const;
  void Hint(const std::string& words) const;
  void Flash(const Rgba& color) const;  // the window's frame, seen without looking at it
  // Where a mode says what it is and what its keys do.
  void Mode(const std::vector<TableRow>& rows) const;
  // On both sides of an upright line.
  void BesideLine(const Eigen::Vector2d& top, const std::string& left, const std::string& right) const;

 private:
  void Table(const std::vector<TableRow>& rows, const Eigen::Vector2d& corner, const Eigen::Vector2d& anchor,
             double wrap_points = 0) const;
  double Px(double points) const { return points * scale_; }

  Painter& painter_;
  const cv::Size screen_;
  const double scale_;
  const Palette& palette_;
};

}  // namespace ulf
