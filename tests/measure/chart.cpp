// The only gnuplot text of all charts.

#include "tests/measure/chart.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/base/quantile.h"
#include "tests/measure/chart_layout.h"
#include "tests/measure/gnuplot.h"

namespace ulf::test {
namespace {

bool IsDrawn(const ChartRow& point) {
  return std::isfinite(point.cost.median) && std::isfinite(point.error.median);
}

constexpr std::array kColors{"#1f63b4", "#d95f02", "#4d8c15", "#7a5195", "#c2185b",
                             "#00838f", "#8d6e1a", "#5c6670", "#e08a8a", "#3aa7a0"};
constexpr const char* kColor(std::size_t series) { return kColors[series % kColors.size()]; }

// Without the marks that only a page shows.
std::string Plain(std::string text) {
  std::erase(text, '`');
  return text;
}

struct LegendEntry {
  std::string text;
  std::string mark;  // gnuplot's, of a point; empty: a dashed line
};

std::vector<std::string> SeriesOf(const Chart& chart) {
  std::vector<std::string> series;
  for (const ChartPanel& panel : chart.panels)
    for (const ChartRow& point : panel.points)
      if (std::ranges::find(series, point.series) == series.end()) series.push_back(point.series);
  return series;
}

std::vector<LegendEntry> LegendOf(const Chart& chart, const std::vector<std::string>& series) {
  std::vector<LegendEntry> legend;
  for (std::size_t s = 0; s < series.size(); ++s)
    if (!series[s].empty())
      legend.push_back({Plain(series[s]), fmt::format("pt 7 ps 1.1 lc rgb '{}'", kColor(s))});
  bool ringed = false, compared = false;
  for (const ChartPanel& panel : chart.panels) {
    compared = compared || panel.compared;
    for (const ChartRow& point : panel.points) ringed = ringed || point.is_default;
  }
  if (ringed) legend.push_back({"the default", "pt 6 ps 2.4 lw 2 lc rgb '#000000'"});
  if (compared) legend.push_back({"Pareto front", ""});
  return legend;
}

double LegendWidth(const LegendEntry& entry) { return 44 + 7.1 * static_cast<double>(entry.text.size()); }

// Breaks the legend into lines of the picture's width.
std::vector<std::vector<LegendEntry>> Broken(const std::vector<LegendEntry>& legend, double width) {
  std::vector<std::vector<LegendEntry>> lines(1);
  double used = 0;
  for (const LegendEntry& entry : legend) {
    if (used > 0 && used + LegendWidth(entry) > width) {
      lines.emplace_back();
      used = 0;
    }
    lines.back().push_back(entry);
    used += LegendWidth(entry);
  }
  return lines;
}

// Collects gnuplot's commands; coordinates are pixels of the whole picture.
class ChartScript {
 public:
  ChartScript(const Chart& chart, const ChartLayout& layout) : chart_(chart), layout_(layout) {}

  void Text(double x, double y, const std::string& text, const std::string& style) {
    script_ += fmt::format("set label {} at screen {:.5f}, screen {:.5f} {} noenhanced\n",
                           QuotedForGnuplot(Plain(text)), x / layout_.width, 1 - y / layout_.height, style);
  }
  void Line(double from_x, double from_y, double to_x, double to_y, const std::string& style) {
    script_ +=
        fmt::format("set arrow from screen {:.5f}, screen {:.5f} to screen {:.5f}, screen {:.5f} nohead {}\n",
                    from_x / layout_.width, 1 - from_y / layout_.height, to_x / layout_.width,
                    1 - to_y / layout_.height, style);
  }
  void Legend(const std::vector<std::vector<LegendEntry>>& lines) {
    double y = layout_.legend_top;
    for (const auto& line : lines) {
      double x = 24;
      for (const LegendEntry& entry : line) {
        if (entry.mark.empty()) Line(x - 9, y, x + 11, y, "dt 2 lw 2 lc rgb '#606060'");
        Text(x + 16, y, entry.text, "left font ',10'");
        if (!entry.mark.empty()) Text(x, y, "", "point " + entry.mark);
        x += LegendWidth(entry);
      }
      y += 20;
    }
  }
  void Panel(std::size_t index, const std::vector<std::string>& series);
  std::string Finished() const { return script_ + "unset multiplot\n"; }
  void Begin() { script_ += "set multiplot\nunset key\nset bars 0\nset border 3 lc rgb '#808080'\n"; }

 private:
  void Axis(char axis, const ChartAxis& described, const ChartScale& scale);
  void Data(const std::string& name, const std::vector<ChartRow>& points);

  const Chart& chart_;
  const ChartLayout& layout_;
  std::string script_;
};

void ChartScript::Axis(char axis, const ChartAxis& described, const ChartScale& scale) {
  script_ +=
      fmt::format("{} logscale {}\nset {}range [{:.8g}:{:.8g}]\nset {}label {} noenhanced\n",
                  scale.logarithmic ? "set" : "unset", axis, axis, scale.falls ? scale.high : scale.low,
                  scale.falls ? scale.low : scale.high, axis, QuotedForGnuplot(Plain(described.label)));
  std::string tics;
  for (const double tic : scale.tics)
    tics += fmt::format("{}'{:g}' {:.8g}", tics.empty() ? "" : ", ", tic, tic);
  script_ +=
      fmt::format("set {}tics nomirror ({})\nset grid {}tics lc rgb '#e8e8e8' lt 1\n", axis, tics, axis);
}

// x y and the ends of their bars.
void ChartScript::Data(const std::string& name, const std::vector<ChartRow>& points) {
  script_ += "$" + name + " << EOD\n";
  for (const ChartRow& p : points)
    if (IsDrawn(p))
      script_ += fmt::format("{:.6g} {:.6g} {:.6g} {:.6g} {:.6g} {:.6g}\n", p.cost.median, p.error.median,
                             p.cost.low, p.cost.high, p.error.low, p.error.high);
  script_ += "NaN NaN NaN NaN NaN NaN\nEOD\n";
}

void ChartScript::Panel(std::size_t index, const std::vector<std::string>& series) {
  const ChartPanel& panel = chart_.panels[index];
  const ChartBox& box = layout_.panels[index];
  std::vector<Spread> costs, errors;
  for (const ChartRow& point : panel.points) {
    if (!std::isfinite(point.cost.median)) continue;
    const bool drawn = std::isfinite(point.error.median);
    if (drawn || chart_.same_costs) costs.push_back(point.cost);
    if (drawn) errors.push_back(point.error);
  }
  if (panel.diagonal) {
    costs.insert(costs.end(), errors.begin(), errors.end());
    errors = costs;
  }
  ChartScale cost = ScaleOf(costs, panel.cost.logarithmic);
  cost.falls = panel.cost.falls;
  const ChartScale error = ScaleOf(errors, panel.error.logarithmic, panel.error.from_zero);
  script_ += fmt::format(
      "set lmargin at screen {:.5f}\nset rmargin at screen {:.5f}\nset tmargin at screen {:.5f}\n"
      "set bmargin at screen {:.5f}\n",
      box.left / layout_.width, box.right / layout_.width, 1 - box.top / layout_.height,
      1 - box.bottom / layout_.height);
  Axis('x', panel.cost, cost);
  Axis('y', panel.error, error);
  Text(0.5 * (box.left + box.right), box.top - 16, panel.title, "center font ',11'");
  for (const PlacedName& name : PlaceNames(panel, cost, error, box)) {
    if (!name.beside)
      Line(name.x, name.y, std::clamp(name.x, name.box.left, name.box.right),
           std::clamp(name.y, name.box.top, name.box.bottom), "lw 0.7 lc rgb '#909090'");
    Text(0.5 * (name.box.left + name.box.right), 0.5 * (name.box.top + name.box.bottom),
         panel.points[name.point].name, "center font ',9' front textcolor rgb '#303030'");
  }
  std::vector<ChartRow> front, ringed;
  for (const std::size_t i : ParetoFront(panel)) front.push_back(panel.points[i]);
  for (const ChartRow& point : panel.points)
    if (point.is_default) ringed.push_back(point);
  const auto name = [&](const std::string& kind) { return kind + std::to_string(index); };
  Data(name("front"), front);
  Data(name("ringed"), ringed);
  if (panel.diagonal)
    script_ += "set arrow from graph 0, graph 0 to graph 1, graph 1 nohead lw 1 lc rgb '#a0a0a0'\n";
  std::string plot = fmt::format("plot ${} with steps dt 2 lw 2 lc rgb '#606060'", name("front"));
  for (std::size_t s = 0; s < series.size(); ++s) {
    std::vector<ChartRow> points;
    for (const ChartRow& point : panel.points)
      if (point.series == series[s]) points.push_back(point);
    if (points.empty()) continue;
    const std::string data = name(fmt::format("s{}_", s));
    Data(data, points);
    plot += fmt::format(
        ", ${0} with xyerrorbars pt 0 lw 1 lc rgb '{1}', ${0} using 1:2 with {2} pt 7 ps 1 lc rgb '{1}'",
        data, kColor(s), panel.joined ? "linespoints lw 1.4" : "points");
  }
  script_ +=
      plot + fmt::format(", ${} using 1:2 with points pt 6 ps 2.6 lw 2 lc rgb '#000000'\n", name("ringed"));
  script_ += "unset label\nunset arrow\n";
}

}  // namespace

Spread Spread::Of(const std::vector<double>& values) {
  if (values.empty()) return Exactly(std::numeric_limits<double>::quiet_NaN());
  const auto [lowest, highest] = std::ranges::minmax(values);
  return {Median(values), lowest, highest};
}

std::vector<std::size_t> ParetoFront(const ChartPanel& panel) {
  std::vector<std::size_t> front;
  if (!panel.compared) return front;
  const auto error = [&](std::size_t i) {
    return (panel.error.more_is_better ? -1 : 1) * panel.points[i].error.median;
  };
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < panel.points.size(); ++i)
    if (IsDrawn(panel.points[i])) order.push_back(i);
  std::ranges::stable_sort(order, [&](std::size_t a, std::size_t b) {
    const double cost_a = panel.points[a].cost.median, cost_b = panel.points[b].cost.median;
    return cost_a != cost_b ? cost_a < cost_b : error(a) < error(b);
  });
  for (const std::size_t i : order)
    if (front.empty() || error(i) < error(front.back())) front.push_back(i);
  return front;
}

ChartPicture PictureOf(const Chart& chart) {
  const std::vector<std::string> series = SeriesOf(chart);
  const double width = LayoutOf(chart, 1, 1).width;
  const auto legend = Broken(LegendOf(chart, series), width - 40);
  auto notes = Lines(chart.about + " " + chart.found, static_cast<std::size_t>(width / 6.7));
  const auto caption = Lines(chart.caption, static_cast<std::size_t>(width / 6.7));
  notes.insert(notes.end(), caption.begin(), caption.end());
  const ChartLayout layout = LayoutOf(chart, static_cast<int>(legend.size()), static_cast<int>(notes.size()));
  ChartScript script(chart, layout);
  script.Begin();
  script.Text(16, 20, chart.title, "left font ',14'");
  script.Legend(legend);
  for (std::size_t i = 0; i < notes.size(); ++i)
    script.Text(16, layout.notes_top + 17.0 * static_cast<double>(i), notes[i],
                "left font ',9' textcolor rgb '#606060'");
  for (std::size_t i = 0; i < chart.panels.size(); ++i) script.Panel(i, series);
  return {layout.width, layout.height, script.Finished()};
}

void DrawChartFile(const std::string& path, const Chart& chart) {
  const ChartPicture picture = PictureOf(chart);
  DrawChart(path, picture.width, picture.height, picture.script);
}

}  // namespace ulf::test
