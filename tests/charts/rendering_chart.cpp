// What a picture is worth and what it costs: blending fields and their levels, over the plane and over the
// light field's own mesh, at two sizes.
#include "render/fields/field_options.h"
#include "render/gl/gl_renderer.h"
#include "render/proxy/points_proxy.h"
#include "render/proxy/soft_proxy.h"
#include "render/stereo/proxy_builder.h"
#include "tests/charts/studio_views.h"
#include "tests/measure/runner.h"
#include "tests/measure/table.h"
#include "tests/support/floors.h"

namespace ulf::test {
namespace {

struct NamedField {
  const char* name;
  FieldOptions field;
};

std::vector<NamedField> Fields(const Effort& effort) {
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

std::vector<NamedField> SoftFields(const Effort& effort) {
  const NamedField wide{"soft 0.8", {.kind = FieldKind::kSoft, .soft_width = 0.8}};
  if (effort.quick) return {wide};
  return {{"soft 0.5", {.kind = FieldKind::kSoft, .soft_width = 0.5}}, wide};
}

// Titles are sizes of pictures: the small ones are also judged by likeness and in motion.
struct Panels {
  explicit Panels(const StudioOptions& size) : psnr(fmt::format("{} x {}", size.width, size.height)) {}
  std::string psnr, ssim = psnr + ", likeness", motion = psnr + ", in motion";
};

Chart MeasurePictures(const Effort& effort) {
  const StudioOptions large{}, small{.width = 240, .height = 160};
  const Panels of_large(large), of_small(small);
  Table table;
  const auto panel = [&](const std::string& title, const ChartAxis& error) {
    table.Panel(title, Log("a picture [ms, CPU]"), error, {.joined = false});
  };
  panel(of_small.psnr, {"PSNR [dB]", false, true});
  panel(of_large.psnr, {"PSNR [dB]", false, true});
  panel(of_small.ssim, {"SSIM", false, true});
  panel(of_small.motion, {"temporal error [levels of 255]"});
  for (const unsigned seed : effort.Seeds(3)) {
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
    for (const bool is_small : {true, false}) {
      const auto truth = StudioTruth(with_seed(is_small ? small : large), effort.Of(3, 12));
      const auto renderer = MakeRenderer(scene, {});
      for (const auto& [series, proxy, fields] : all_series) {
        renderer->SetProxy(proxy);
        for (const auto& [name, field] : fields) {
          renderer->SetField(field);
          const bool in_use = field.kind == FieldKind::kSubdivision && field.level == 1;
          const RenderedQuality quality = MeasureRendering(*renderer, truth);
          const auto add = [&, series = series, name = name](const std::string& title, double value) {
            table.Add(title, series, name, quality.cpu_ms, value, in_use);
          };
          add(is_small ? of_small.psnr : of_large.psnr, quality.psnr_db);
          if (!is_small) continue;
          add(of_small.ssim, quality.ssim);
          if (field.kind != FieldKind::kLumigraphPerPixel)
            add(of_small.motion, TemporalErrorAlong(*renderer, path));
        }
      }
    }
  }
  return {.panels = table.panels()};
}

CHART(rendering, MeasurePictures, "Rendering: fields, levels, proxies and sizes", R"(The simulated studio,
  three seeds, views for a threshold of 12 px, software OpenGL or what there is; 12 pictures of each seed
  from places that were not recorded, whole frames. Temporal error: 48 pictures of a hand's way, root mean
  square of the second difference of (rendering - truth). Processor time, reading the picture back included;
  bars: lowest to highest seed. Ringed: without being asked for another field; weights per pixel are too
  slow to be looked at in motion.)");

}  // namespace
}  // namespace ulf::test
