// Geometry by the size of the photographs it is made of: what it costs, and what pictures over it are worth.
#include <utility>

#include "render/fields/field_options.h"
#include "render/gl/gl_renderer.h"
#include "render/proxy/soft_proxy.h"
#include "render/stereo/proxy_builder.h"
#include "tests/charts/studio_views.h"
#include "tests/measure/runner.h"
#include "tests/measure/table.h"
#include "tests/support/floors.h"

namespace ulf::test {
namespace {

constexpr char kDisc[] = "the subject (its sphere's silhouette)", kFrame[] = "the whole frame";

Chart MeasureGeometry(const Effort& effort) {
  const std::vector<std::pair<const char*, FieldOptions>> fields{
      {"mesh, subdivision", {.kind = FieldKind::kSubdivision}},
      {"mesh and depth maps, soft 0.8", {.kind = FieldKind::kSoft, .soft_width = 0.8}}};
  constexpr int kDefaultPx = ProxyOptions{}.size_px;
  Table table;
  for (const char* title : {kDisc, kFrame})
    table.Panel(title, Log("making the geometry [s, CPU]"), MoreIsBetter({"PSNR [dB]"}), {.joined = false});
  for (const unsigned seed : effort.Seeds(3)) {
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
        const std::string name = fmt::format("{} px", size_px);
        table.Add(kDisc, series, name, cpu_s, quality.psnr_disc_db, size_px == kDefaultPx);
        table.Add(kFrame, series, name, cpu_s, quality.psnr_db, size_px == kDefaultPx);
      }
    }
  }
  return {.panels = table.panels()};
}

CHART(geometry, MeasureGeometry, "Geometry: decibels and seconds", R"(The simulated studio, three seeds,
  photographs of 960 x 640, views for a threshold of 12 px; mesh and depth maps from 24 views, names are the
  longer side of the photographs that are compared. 12 pictures of each seed from places that were not
  recorded. Processor time of all threads; bars: lowest to highest seed. Ringed: the default.)");

}  // namespace
}  // namespace ulf::test
