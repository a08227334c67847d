// Where things of a chart stand, in pixels of its picture (x to the right, y down): panels, their scales, and
// names beside points where nothing else is.
#pragma once

#include <string>
#include <vector>

#include "core/plot/chart.h"

namespace ulf {

struct ChartBox {
  double left = 0, top = 0, right = 0, bottom = 0;
  bool Overlaps(const ChartBox& other) const {
    return left < other.right && other.left < right && top < other.bottom && other.top < bottom;
  }
};

// From a value to a share of the axis, 0 to 1.
struct ChartScale {
  double low = 0, high = 1;
  bool logarithmic = false;
  double Share(double value) const;
  std::vector<double> tics;
  bool falls = false;  // `high` is where the axis begins
};
// Holds all values and their bars, with a margin.
ChartScale ScaleOf(const std::vector<ChartSpread>& values, bool logarithmic, bool from_zero = false);

struct PlacedName {
  std::size_t point = 0;
  ChartBox box;
  bool beside = true;   // its point; else a line leads there
  double x = 0, y = 0;  // of the point
};
// Beside their points, over no other name and no point, the ringed one's first; over bars and lines where
// there is no other place. Those without room are left out, or stand farther off where the panel wants all.
std::vector<PlacedName> PlaceNames(const ChartPanel& panel, const ChartScale& cost, const ChartScale& error,
                                   const ChartBox& inside);

struct ChartLayout {
  int width = 0, height = 0;
  double legend_top = 0, notes_top = 0;
  std::vector<ChartBox> panels;  // their axes
};
ChartLayout LayoutOf(const Chart& chart, int legend_lines, int note_lines);

inline constexpr double kNameHeight = 14, kNameCharacter = 6.2;  // px
// Broken between words.
std::vector<std::string> Lines(const std::string& text, std::size_t characters);

}  // namespace ulf
