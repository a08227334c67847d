// What a picture is worth and what it costs: blending fields and their levels, over the plane and over the
// light field's own mesh, at two sizes.
#include <map>

#include "render/fields/field_options.h"
#include "render/gl/gl_renderer.h"
#include "render/proxy/points_proxy.h"
#include "render/proxy/soft_proxy.h"
#include "render/stereo/proxy_builder.h"
#include "tests/charts/makers.h"
#include "tests/charts/studio_views.h"
#include "tests/support/floors.h"

namespace ulf::test {
namespace {

struct Row {
  std::string series, name;
  bool is_default = false;
  std::vector<double> ms = {}, psnr_db = {}, ssim = {}, restless = {};
};

struct NamedField {
  const char* name;
  FieldOptions field;
};

std::vector<NamedField> Fields(const ChartEffort& effort) {
  const NamedField linear{"linear", {.kind = FieldKind::kLinear}},
      once{"1 level", {.kind = FieldKind::kSubdivision, .level = 1}},
      lumigraph{"lumigraph", {.kind = FieldKind::kLumigraph}};
  if (effort.quick) return {linear, once, lumigraph};
  return {{"nearest", {.kind = FieldKind::kNearest}},
          linear,
          once,
          {"2 levels", {.kind = FieldKind::kSubdivision, .level = 2}},
          lumigraph,
          {"per pixel", {.kind = FieldKind::kLumigraphPerPixel}}};
}

std::vector<NamedField> SoftFields(const ChartEffort& effort) {
  const NamedField wide{"soft 0.8", {.kind = FieldKind::kSoft, .soft_width = 0.8}};
  if (effort.quick) return {wide};
  return {{"soft 0.5", {.kind = FieldKind::kSoft, .soft_width = 0.5}}, wide};
}

ChartPanel PanelOf(const std::string& title, const ChartAxis& axis, const std::vector<Row>& rows,
                   std::vector<double> Row::*value) {
  ChartPanel panel{title, {"a picture [ms, CPU]", true}, axis, {}, true, false};
  for (const Row& row : rows)
    if (!(row.*value).empty())
      panel.points.push_back(
          {row.series, row.name, Spread::Of(row.ms), Spread::Of(row.*value), row.is_default});
  return panel;
}

}  // namespace

Chart RenderingChart(const ChartEffort& effort) {
  std::map<std::string, std::vector<Row>> by_size;
  const StudioOptions large{}, small{.width = 240, .height = 160};
  for (const unsigned seed : effort.Of(std::vector{1u}, {1u, 2u, 3u})) {
    const auto with_seed = [&](StudioOptions options) {
      options.seed = seed;
      options.threshold_px = effort.Of(24.0, 12.0);
      return options;
    };
    const auto scene = StudioScene(with_seed(large));
    ProxyMesh geometry = BuildProxy(*scene, {.depth_maps = effort.Of(8, 24), .keep_maps = true});
    const auto mesh = std::make_shared<TriangleMesh>(std::move(geometry.mesh));
    struct Series {
      const char* name;
      std::shared_ptr<const Proxy> proxy;
      std::vector<NamedField> fields;
    };
    const std::vector<Series> all_series{
        {"over the plane", scene->proxy, Fields(effort)},
        {"over 3,000 points",
         std::make_shared<PointsProxy>(scene->subject, StudioPoints(with_seed(large), 3000)), Fields(effort)},
        {"over the mesh of ulf proxy", std::make_shared<MeshProxy>(scene->subject, mesh), Fields(effort)},
        {"over the mesh and depth maps",
         std::make_shared<SoftProxy>(scene->subject, mesh, SoftProxy::InMemory(std::move(geometry.maps))),
         SoftFields(effort)}};
    const std::vector<TruePicture> path = StudioPath(with_seed(small), effort.Of(8, 48));
    for (const StudioOptions& size : {small, large}) {
      std::vector<Row>& rows = by_size[fmt::format("{} x {}", size.width, size.height)];
      std::size_t next = 0;
      const auto truth = StudioTruth(with_seed(size), effort.Of(3, 12));
      const auto renderer = MakeRenderer(scene, {});
      for (const auto& [series, proxy, fields] : all_series) {
        renderer->SetProxy(proxy);
        for (const auto& [name, field] : fields) {
          renderer->SetField(field);
          const RenderedQuality quality = MeasureRendering(*renderer, truth);
          if (next == rows.size())
            rows.push_back({series, name, field.kind == FieldKind::kSubdivision && field.level == 1});
          Row& row = rows[next++];
          row.ms.push_back(quality.cpu_ms);
          row.psnr_db.push_back(quality.psnr_db);
          row.ssim.push_back(quality.ssim);
          const bool in_motion = size.width == small.width && field.kind != FieldKind::kLumigraphPerPixel;
          if (in_motion) row.restless.push_back(TemporalErrorAlong(*renderer, path));
        }
      }
    }
  }
  Chart chart;
  chart.title = "Rendering: fields, levels, proxies and sizes";
  chart.about = fmt::format(
      "The simulated studio, seeds 1 to 3 (made with seed 7), views for a threshold of {} px, software "
      "OpenGL "
      "or what there is; {} pictures of each seed from places that were not recorded, whole frames. Temporal "
      "error: {} pictures of a hand's way, root mean square of the second difference of (rendering - truth). "
      "Processor time, reading the picture back included; bars: lowest to highest seed. Ringed: without "
      "being asked for another field; weights per pixel are too slow to be looked at in motion.",
      effort.Of(24, 12), effort.Of(3, 12), effort.Of(8, 48));
  for (const auto& [size, rows] : by_size)
    chart.panels.push_back(PanelOf(size, {"PSNR [dB]", false, true}, rows, &Row::psnr_db));
  const auto& [size, rows] = *by_size.begin();
  chart.panels.push_back(PanelOf(size + ", likeness", {"SSIM", false, true}, rows, &Row::ssim));
  chart.panels.push_back(
      PanelOf(size + ", in motion", {"temporal error [levels of 255]"}, rows, &Row::restless));
  return chart;
}

}  // namespace ulf::test
