// What a threshold of the coverage bound buys: views recorded against how well what lies between is shown.
#include "render/gl/gl_renderer.h"
#include "render/proxy/points_proxy.h"
#include "tests/charts/studio_views.h"
#include "tests/measure/runner.h"
#include "tests/measure/table.h"
#include "tests/support/floors.h"

namespace ulf::test {
namespace {

constexpr char kDisc[] = "the subject (its sphere's silhouette)", kFrame[] = "the whole frame";

Chart MeasureThresholds(const Effort& effort) {
  Table table;
  for (const char* title : {kDisc, kFrame})
    table.Panel(title, Log("views recorded"), MoreIsBetter({"PSNR [dB]"}), {.compared = false});
  for (const unsigned seed : effort.Seeds(3)) {
    const auto truth = StudioTruth({.seed = seed}, effort.Of(8, 12));
    const auto points = StudioPoints({.seed = seed}, 3000);
    for (const double threshold_px : effort.Of(std::vector{12.0, 24.0}, {7.0, 9.0, 12.0, 17.0, 24.0, 34.0})) {
      const auto scene = StudioScene({.seed = seed, .threshold_px = threshold_px});
      const auto renderer = MakeRenderer(scene, {});
      for (const char* series : {"over the plane", "over the tracked points"}) {
        const RenderedQuality quality = MeasureRendering(*renderer, truth);
        const auto views = static_cast<double>(scene->views.size());
        const std::string name = fmt::format("{:g} px", threshold_px);
        table.Add(kDisc, series, name, views, quality.psnr_disc_db, threshold_px == 7);
        table.Add(kFrame, series, name, views, quality.psnr_db, threshold_px == 7);
        renderer->SetProxy(std::make_shared<PointsProxy>(scene->subject, points));
      }
    }
  }
  return {.panels = table.panels()};
}

CHART(coverage_threshold, MeasureThresholds,
      "Coverage threshold: views recorded for a cap of 60 x 40 degrees, and what they show", R"(The
  simulated studio, three seeds (`--quality` offers 7 px, the default, and 12 px for fast), views as the
  coverage map asks for them, subdivision weights; 12 pictures of each seed from places that were not
  recorded, PSNR against what is really seen there. Points: 3,000 true ones. Bars: lowest to highest seed.)");

}  // namespace
}  // namespace ulf::test
