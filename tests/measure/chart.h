// Describes charts of the cost of methods against their error, which gnuplot draws.
//
// Every panel has a cost on the horizontal axis (time, memory, a count) and an error on the vertical one (or
// a quality, where more is better). The program's default is ringed. The dashed line is the Pareto front: the
// rows that no other row beats in both. A row is a point at the median over seeds or repetitions; its bars
// reach from the lowest value to the highest.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace ulf::test {

struct Spread {
  double median = 0, low = 0, high = 0;
  static Spread Of(const std::vector<double>& values);  // not a number for none
  static Spread Exactly(double value) { return {value, value, value}; }
};

struct ChartRow {
  std::string series = {};  // rows of one series have one colour and are joined by a line, in their order
  std::string name = {};    // beside the point
  Spread cost = {}, error = {};  // rows with one that is not finite are in the table only
  bool is_default = false;
};

struct ChartAxis {
  std::string label = {};
  bool logarithmic = false;
  bool more_is_better = false;  // of an error axis
  bool falls = false;           // the axis begins with the largest value
  bool from_zero = false;       // the axis begins at 0; where it is linear
};

inline ChartAxis Log(const std::string& label) { return {.label = label, .logarithmic = true}; }
inline ChartAxis MoreIsBetter(ChartAxis axis) {
  axis.more_is_better = true;
  return axis;
}
inline ChartAxis FromZero(ChartAxis axis) {
  axis.from_zero = true;
  return axis;
}

struct ChartPanel {
  std::string title = {};
  ChartAxis cost = {}, error = {};
  std::vector<ChartRow> points = {};
  bool compared = true;    // false: rows are not rivals, and have no front
  bool joined = true;      // rows of a series are joined by a line
  bool all_named = false;  // names without room beside their points stand farther off, by a thin line
  // True: both axes are of one quantity. They reach equally far, and a line is drawn where both are equal.
  bool diagonal = false;
};

struct Chart {
  std::string name = {};     // of its files, where it has a folder of its own
  std::string title = {};    // a sentence
  std::string about = {};    // sets, what a row is, and what was tuned on them
  std::string found = {};    // what this run says in figures besides its rows
  std::string caption = {};  // command, machine, date, commit (provenance.h)
  std::vector<ChartPanel> panels = {};
  bool same_costs = false;  // rows without an error take room on the cost axis, so that panels agree
};

// Returns the indices of the rows on the Pareto front, the cheapest first; of equal rows the first.
std::vector<std::size_t> ParetoFront(const ChartPanel& panel);

struct ChartPicture {
  int width = 0, height = 0;  // px
  std::string script;         // for gnuplot
};
ChartPicture PictureOf(const Chart& chart);

// The ending of `path` chooses the format. Throws as DrawChart() of gnuplot.h.
void DrawChartFile(const std::string& path, const Chart& chart);

}  // namespace ulf::test
