// Draws text and tables on a dark ground around a picture. The panels have no state between frames.
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

// Returns pixels per point for texts: the screen's, or fewer in small windows, where they would overlap.
double ScaleOf(const Surface& surface);

// An item of the status line; items are drawn from left to right.
struct StatusItem {
  std::string text;
  Rgba color = ink::kText;
};

struct TableRow {
  std::optional<Rgba> swatch;  // a square of this colour before the row
  std::string left = {}, right = {};
  Rgba color = ink::kText;
};

struct KeyHelp {
  const char *keys, *what;  // names of keys, and what they do
};

// Draws the panels of one frame. `scale` is in pixels per point.
class PlainPanels {
 public:
  PlainPanels(Painter& painter, const cv::Size& screen, double scale)
      : painter_(painter), screen_(screen), scale_(scale) {}

  void Status(const std::vector<StatusItem>& items) const;  // along the top
  // `anchor` is the point of the table that lies at `corner` (px): 0,0 its upper left, 1,1 its lower right.
  void Table(const std::vector<TableRow>& rows, const Eigen::Vector2d& corner, const Eigen::Vector2d& anchor,
             double wrap_points = 0) const;
  void Instruction(const std::string& words, const Rgba& color) const;  // large, below the middle
  void Notice(const std::string& words) const;  // above the instruction: the result of a request
  void Hint(const std::string& words) const;    // in the lower right corner
  // Draws the name and the keys of a mode in the lower left corner.
  void Mode(const std::vector<TableRow>& rows) const;
  // Draws the rows over the darkened picture, in two tables if a row without words on the left parts them.
  void Keys(const std::vector<TableRow>& rows) const;
  void Flash(const Rgba& color) const;  // along the window's edges, visible from the corner of the eye

 protected:
  double Px(double points) const { return points * scale_; }

  Painter& painter_;
  const cv::Size screen_;
  const double scale_;
};

}  // namespace ulf::render
