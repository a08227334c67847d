#include "tests/measure/chart_file.h"

#include <fmt/core.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/base/error.h"

namespace ulf::test {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kColumns =
    "panel,series,name,cost,cost_low,cost_high,error,error_low,error_high,default,front";

Json AxisJson(const ChartAxis& axis) {
  return {{"label", axis.label},
          {"logarithmic", axis.logarithmic},
          {"more_is_better", axis.more_is_better},
          {"falls", axis.falls},
          {"from_zero", axis.from_zero}};
}
ChartAxis AxisFrom(const Json& json) {
  return {json.at("label"), json.at("logarithmic"), json.at("more_is_better"), json.value("falls", false),
          json.value("from_zero", false)};
}

Json HeadJson(const Chart& chart) {
  Json panels = Json::array();
  for (const ChartPanel& panel : chart.panels)
    panels.push_back({{"title", panel.title},
                      {"cost", AxisJson(panel.cost)},
                      {"error", AxisJson(panel.error)},
                      {"compared", panel.compared},
                      {"joined", panel.joined},
                      {"all_named", panel.all_named},
                      {"diagonal", panel.diagonal}});
  return {{"name", chart.name},   {"title", chart.title},     {"about", chart.about},
          {"found", chart.found}, {"caption", chart.caption}, {"same_costs", chart.same_costs},
          {"panels", panels}};
}

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
  file << "# " << HeadJson(chart).dump() << "\n" << kColumns << "\n";
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
  const Json head = Json::parse(line.substr(2));
  Chart chart{.name = head.at("name"),
              .title = head.at("title"),
              .about = head.at("about"),
              .found = head.value("found", ""),
              .caption = head.at("caption"),
              .same_costs = head.value("same_costs", false)};
  for (const Json& panel : head.at("panels"))
    chart.panels.push_back({panel.at("title"),
                            AxisFrom(panel.at("cost")),
                            AxisFrom(panel.at("error")),
                            {},
                            panel.at("compared"),
                            panel.at("joined"),
                            panel.value("all_named", false),
                            panel.value("diagonal", false)});
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
