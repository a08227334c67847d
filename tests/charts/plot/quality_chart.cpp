#include "tests/charts/plot/quality_chart.h"

#include <fmt/core.h>

#include "core/base/counted.h"

namespace ulf::render {
namespace {

std::string NameOf(const FieldScore& score) {
  const std::string used = FieldText(score.used);
  return score.asked.kind == score.used.kind ? used
                                             : fmt::format("{} as {}", FieldName(score.asked.kind), used);
}

}  // namespace

ChartRow QualityRow(const std::string& series, const std::string& name, double ms, double psnr_db) {
  return {series, name, ChartSpread::Exactly(ms), ChartSpread::Exactly(psnr_db), false};
}

Chart QualityChart(const std::string& title, const std::string& about, std::vector<ChartRow> points) {
  Chart chart{.name = "quality", .title = title, .about = about, .caption = {}, .panels = {}};
  chart.panels.push_back(
      {.title = {},
       .cost = {.label = "milliseconds a picture", .logarithmic = true},
       .error = {.label = "PSNR of left-out views, dB", .logarithmic = false, .more_is_better = true},
       .points = std::move(points),
       .joined = false,
       .all_named = true});
  return chart;
}

Chart QualityChart(const EvaluateSummary& summary, const std::string& light_field) {
  std::vector<ChartRow> points;
  bool all_inside = true;
  for (const FieldScore& score : summary.results) {
    const MeanScore& main = score.Main();
    all_inside = all_inside && &main == &score.inside;
    points.push_back(QualityRow(score.proxy, NameOf(score), score.ms_per_frame, main.psnr_db));
  }
  const int inside = summary.results.empty() ? 0 : summary.results.front().inside.views;
  const std::string which =
      all_inside ? fmt::format("the {} of them inside the hull", inside) : "all of them";
  return QualityChart(
      fmt::format("{}: how good pictures of left-out views are, and what they cost", light_field),
      fmt::format(
          "{} of {} left out; means over {}; {}x{} on {}. Pareto front: no other is both faster and better.",
          summary.held_out, Counted(summary.views, "view"), which, summary.width, summary.height,
          summary.renderer),
      std::move(points));
}

}  // namespace ulf::render
