// Lays out a chart in pixels of its picture (x right, y down): panels, their scales, and places for the names
// of points.
#pragma once

#include <string>
#include <vector>

#include "tests/measure/chart.h"

namespace ulf::test {

struct ChartBox {
  double left = 0, top = 0, right = 0, bottom = 0;
  bool Overlaps(const ChartBox& other) const {
    return left < other.right && other.left < right && top < other.bottom && other.top < bottom;
  }
};

// Maps a value to a share of the axis, 0 to 1.
struct ChartScale {
  double low = 0, high = 1;
  bool logarithmic = false;
  double Share(double value) const;
  std::vector<double> tics;
  bool falls = false;  // the axis begins with `high`
};
// Returns the scale that shows all values and their bars, with a margin.
ChartScale ScaleOf(const std::vector<Spread>& values, bool logarithmic, bool from_zero = false);

struct PlacedName {
  std::size_t point = 0;  // its index in the panel
  ChartBox box;
  bool beside = true;   // beside its point; else a line connects the two
  double x = 0, y = 0;  // of the point
};
// Places names beside their points, the default's first, so that they cover no name and no point, and bars
// and lines only where there is no other place. Names without room are left out, or stand farther off where
// the panel wants all names.
std::vector<PlacedName> PlaceNames(const ChartPanel& panel, const ChartScale& cost, const ChartScale& error,
                                   const ChartBox& inside);

struct ChartLayout {
  int width = 0, height = 0;
  double legend_top = 0, notes_top = 0;
  std::vector<ChartBox> panels;  // within their axes
};
ChartLayout LayoutOf(const Chart& chart, int legend_lines, int note_lines);

inline constexpr double kNameHeight = 14, kNameCharacter = 6.2;  // px; the second: a character's width
// Returns the text in lines of at most so many characters, broken between words.
std::vector<std::string> Lines(const std::string& text, std::size_t characters);

}  // namespace ulf::test
