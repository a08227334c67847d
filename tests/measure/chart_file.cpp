#include "tests/measure/chart_file.h"

#include <fmt/core.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/base/error.h"

namespace ulf::test {

// The head of a table: everything but rows.
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE_WITH_DEFAULT(ChartAxis, label, logarithmic, more_is_better, falls,
                                                from_zero)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE_WITH_DEFAULT(ChartPanel, title, cost, error, compared, joined, all_named,
                                                diagonal)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE_WITH_DEFAULT(Chart, name, title, about, found, caption, same_costs, panels)

namespace {

constexpr const char* kColumns =
    "panel,series,name,cost,cost_low,cost_high,error,error_low,error_high,default,front";

std::string Quoted(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? "\"\"" : std::string(1, c);
  return quoted + "\"";
}

std::vector<std::string> Fields(const std::string& line) {
  std::vector<std::string> fields(1);
  bool quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (line[i] == '"' && quoted && i + 1 < line.size() && line[i + 1] == '"')
      fields.back() += line[++i];
    else if (line[i] == '"')
      quoted = !quoted;
    else if (line[i] == ',' && !quoted)
      fields.emplace_back();
    else
      fields.back() += line[i];
  }
  return fields;
}

}  // namespace

void WriteChart(const std::filesystem::path& table, const Chart& chart) {
  std::ofstream file(table);
  file << "# " << nlohmann::json(chart).dump() << "\n" << kColumns << "\n";
  for (const ChartPanel& panel : chart.panels) {
    const auto front = ParetoFront(panel);
    for (std::size_t i = 0; i < panel.points.size(); ++i) {
      const ChartRow& p = panel.points[i];
      file << fmt::format("{},{},{},{:.5g},{:.5g},{:.5g},{:.5g},{:.5g},{:.5g},{:d},{:d}\n",
                          Quoted(panel.title), Quoted(p.series), Quoted(p.name), p.cost.median, p.cost.low,
                          p.cost.high, p.error.median, p.error.low, p.error.high, p.is_default,
                          std::find(front.begin(), front.end(), i) != front.end());
    }
  }
  if (!file.flush()) throw Error("{}: the table cannot be written; is there room?", table.string());
}

Chart ReadChart(const std::filesystem::path& table) {
  std::ifstream file(table);
  std::string line;
  if (!std::getline(file, line) || !line.starts_with("# {"))
    throw Error("{}: not the table of a chart; measure it anew", table.string());
  Chart chart = nlohmann::json::parse(line.substr(2)).get<Chart>();
  std::getline(file, line);
  while (std::getline(file, line)) {
    const auto fields = Fields(line);
    const auto panel = std::find_if(chart.panels.begin(), chart.panels.end(),
                                    [&](const ChartPanel& p) { return p.title == fields[0]; });
    if (fields.size() != 11 || panel == chart.panels.end())
      throw Error("{}: not a row of this chart: {}", table.string(), line);
    const auto number = [&](std::size_t i) { return std::strtod(fields[i].c_str(), nullptr); };
    panel->points.push_back({fields[1],
                             fields[2],
                             {number(3), number(4), number(5)},
                             {number(6), number(7), number(8)},
                             fields[9] == "1"});
  }
  return chart;
}

void DrawChart(const std::filesystem::path& folder, const Chart& chart) {
  for (const char* ending : {".svg", ".png"}) DrawChartFile((folder / (chart.name + ending)).string(), chart);
}

}  // namespace ulf::test
