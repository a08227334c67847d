// Geometry by the size of the photographs it is made of: what it costs, and what pictures over it are worth.
#include <map>

#include "render/fields/field_options.h"
#include "render/gl/gl_renderer.h"
#include "render/proxy/soft_proxy.h"
#include "render/stereo/proxy_builder.h"
#include "tests/charts/makers.h"
#include "tests/charts/studio_views.h"
#include "tests/support/floors.h"

namespace ulf::test {
namespace {

struct GeometryRow {
  std::vector<double> cpu_s, disc_db, frame_db;
};

struct GeometryField {
  const char* series;
  FieldOptions field;
};

}  // namespace

Chart GeometryChart(const ChartEffort& effort) {
  const std::vector<GeometryField> fields{
      {"mesh, subdivision", {.kind = FieldKind::kSubdivision}},
      {"mesh and depth maps, soft 0.8", {.kind = FieldKind::kSoft, .soft_width = 0.8}}};
  constexpr int kDefaultPx = ProxyOptions{}.size_px;
  std::map<std::string, std::map<int, GeometryRow>> rows;
  for (const unsigned seed : effort.Of(std::vector{1u}, {1u, 2u, 3u})) {
    const StudioOptions studio{
        .seed = seed, .threshold_px = effort.Of(24.0, 12.0), .width = 960, .height = 640};
    const auto scene = StudioScene(studio);
    const auto truth = StudioTruth(studio, effort.Of(3, 12));
    const auto renderer = MakeRenderer(scene, {});
    for (const int size_px : effort.Of(std::vector{160, 240}, {160, 240, 320, kDefaultPx, 640, 960})) {
      const double before_ms = ProcessCpuMs();
      ProxyMesh geometry =
          BuildProxy(*scene, {.size_px = size_px, .depth_maps = effort.Of(8, 24), .keep_maps = true});
      const double cpu_s = 1e-3 * (ProcessCpuMs() - before_ms);
      renderer->SetProxy(std::make_shared<SoftProxy>(scene->subject,
                                                     std::make_shared<TriangleMesh>(std::move(geometry.mesh)),
                                                     SoftProxy::InMemory(std::move(geometry.maps))));
      for (const auto& [series, field] : fields) {
        renderer->SetField(field);
        const RenderedQuality quality = MeasureRendering(*renderer, truth);
        GeometryRow& row = rows[series][size_px];
        row.cpu_s.push_back(cpu_s);
        row.disc_db.push_back(quality.psnr_disc_db);
        row.frame_db.push_back(quality.psnr_db);
      }
    }
  }
  Chart chart;
  chart.title = "Geometry: decibels and seconds";
  chart.about = fmt::format(
      "The simulated studio, {}, photographs of 960 x 640, views for a threshold of {} px; mesh and depth "
      "maps "
      "from {} views, names are the longer side of the photographs that are compared. {} pictures of each "
      "seed "
      "from places that were not recorded. Processor time of all threads; bars: lowest to highest seed. "
      "Ringed: the default.",
      effort.Of("seed 1", "seeds 1 to 3"), effort.Of(24, 12), effort.Of(8, 24), effort.Of(3, 12));
  for (const bool disc : {true, false}) {
    ChartPanel panel{disc ? "the subject (its sphere's silhouette)" : "the whole frame",
                     {"making the geometry [s, CPU]", true},
                     {"PSNR [dB]", false, true},
                     {},
                     true,
                     false};
    for (const auto& [series, of_sizes] : rows)
      for (const auto& [size_px, row] : of_sizes)
        panel.points.push_back({series, fmt::format("{} px", size_px), Spread::Of(row.cpu_s),
                                Spread::Of(disc ? row.disc_db : row.frame_db), size_px == kDefaultPx});
    chart.panels.push_back(panel);
  }
  return chart;
}

}  // namespace ulf::test
