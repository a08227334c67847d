// Charts of the cost of methods against their error, drawn by gnuplot.
//
// Every panel has a cost on the horizontal axis (time, memory, a count) and an error on the vertical one (or
// a quality, where more is better). The program's default is ringed. The dashed line is the Pareto front:
// rows that no other row beats in both. A row is the median over seeds or repetitions; its bars reach from
// the lowest value to the highest.
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
  std::string series = {};       // one colour, joined by a line in the order of rows
  std::string name = {};         // beside the point
  Spread cost = {}, error = {};  // those that are not finite are in the table only
  bool is_default = false;
};

struct ChartAxis {
  std::string label = {};
  bool logarithmic = false;
  bool more_is_better = false;  // of an error axis
  bool falls = false;           // the largest stands where the axis begins
  bool from_zero = false;       // where it is linear
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
  bool joined = true;      // by a line
  bool all_named = false;  // names without room beside their points stand farther off, by a thin line
  // Both axes are of one quantity: they reach equally far, and where both are equal a line is drawn.
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

// Indices of the rows that no other row beats in both, the cheapest first; of equal ones the first.
std::vector<std::size_t> ParetoFront(const ChartPanel& panel);

struct ChartPicture {
  int width = 0, height = 0;  // px
  std::string script;
};
ChartPicture PictureOf(const Chart& chart);

// Throws as DrawChart() of gnuplot.h.
void DrawChartFile(const std::string& path, const Chart& chart);

}  // namespace ulf::test
