// Collects what is measured, value by value, and makes a chart's panels of it.
#pragma once

#include <string>
#include <vector>

#include "tests/measure/chart.h"

namespace ulf::test {

// These mean the same as in ChartPanel.
struct PanelLooks {
  bool compared = true, joined = true, all_named = false, diagonal = false;
};

class Table {
 public:
  // Begins a panel, unless one with its title is there.
  void Panel(const std::string& title, const ChartAxis& cost, const ChartAxis& error,
             const PanelLooks& looks = {});
  // Adds a value of a seed, a place or a repetition to a row. A row is known by its series and its name, or
  // by its cost if it has no name; it is the default where more than half of its values say so. Throws Error
  // for a panel that is not there.
  void Add(const std::string& panel, const std::string& series, const std::string& name, double cost,
           double error, bool is_default = false);
  // Returns the panels with their rows in the order of first values: medians, the lowest and the highest.
  std::vector<ChartPanel> panels() const;

 private:
  struct Row {
    std::string series, name;
    std::vector<double> costs = {}, errors = {};
    int defaults = 0;
  };
  struct Collected {
    ChartPanel panel;
    std::vector<Row> rows = {};
  };
  std::vector<Collected> panels_;
};

}  // namespace ulf::test
