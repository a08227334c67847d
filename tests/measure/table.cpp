#include "tests/measure/table.h"

#include <algorithm>

#include "core/base/error.h"

namespace ulf::test {

void Table::Panel(const std::string& title, const ChartAxis& cost, const ChartAxis& error,
                  const PanelLooks& looks) {
  if (std::ranges::none_of(panels_, [&](const Collected& one) { return one.panel.title == title; }))
    panels_.push_back(
        {{title, cost, error, {}, looks.compared, looks.joined, looks.all_named, looks.diagonal}});
}

void Table::Add(const std::string& panel, const std::string& series, const std::string& name, double cost,
                double error, bool is_default) {
  const auto of =
      std::ranges::find_if(panels_, [&](const Collected& one) { return one.panel.title == panel; });
  if (of == panels_.end()) throw Error("no panel of this chart is called '{}'", panel);
  auto row = std::ranges::find_if(of->rows, [&](const Row& one) {
    return one.series == series && one.name == name && (!name.empty() || one.costs.front() == cost);
  });
  if (row == of->rows.end()) row = of->rows.insert(row, Row{series, name});
  row->costs.push_back(cost);
  row->errors.push_back(error);
  row->defaults += is_default;
}

std::vector<ChartPanel> Table::panels() const {
  std::vector<ChartPanel> panels;
  for (const Collected& one : panels_) {
    panels.push_back(one.panel);
    for (const Row& row : one.rows)
      panels.back().points.push_back({row.series, row.name, Spread::Of(row.costs), Spread::Of(row.errors),
                                      2 * row.defaults > static_cast<int>(row.costs.size())});
  }
  return panels;
}

}  // namespace ulf::test
