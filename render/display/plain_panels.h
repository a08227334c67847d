// Words, numbers and tables on dark ground around a picture. Drawing keeps nothing from one frame to the
// next.
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "render/display/painter.h"
#include "render/display/surface.h"

namespace ulf::render {

namespace ink {
inline constexpr Rgba kText{235, 235, 235}, kDim{170, 170, 170}, kGood{110, 220, 120}, kBad{255, 95, 85},
    kCareful{255, 200, 70}, kPanel{0, 0, 0, 175};
}

// Pixels a point: the screen's, but small windows get small text rather than text over text.
double ScaleOf(const Surface& surface);

// One of the status line's, from left to right.
struct StatusItem {
  std::string text;
  Rgba color = ink::kText;
};

struct TableRow {
  std::optional<Rgba> swatch;
  std::string left = {}, right = {};
  Rgba color = ink::kText;
};

struct KeyHelp {
  const char *keys, *what;
};

// On one frame: `scale` pixels a point.
class PlainPanels {
 public:
  PlainPanels(Painter& painter, const cv::Size& screen, double scale)
      : painter_(painter), screen_(screen), scale_(scale) {}

  void Status(const std::vector<StatusItem>& items) const;  // along the top
  // `anchor`: which point of the table is at `corner`: 0,0 its upper left, 1,1 its lower right.
  void Table(const std::vector<TableRow>& rows, const Eigen::Vector2d& corner, const Eigen::Vector2d& anchor,
             double wrap_points = 0) const;
  void Instruction(const std::string& words, const Rgba& color) const;  // large, below the middle
  void Said(const std::string& words) const;  // above it: what came of what was asked
  void Hint(const std::string& words) const;  // in the lower right corner
  // Where a mode says what it is and what its keys do.
  void Mode(const std::vector<TableRow>& rows) const;
  void Keys(const std::vector<TableRow>& rows) const;  // over a darkened picture
  void Flash(const Rgba& color) const;                 // the window's frame, seen without looking at it

 protected:
  double Px(double points) const { return points * scale_; }

  Painter& painter_;
  const cv::Size screen_;
  const double scale_;
};

}  // namespace ulf::render
