// Where more geometry stops helping: the plane, tracked points in number, the light field's own mesh with
// ever fewer triangles.
#include <array>
#include <map>

#include "render/fields/field_options.h"
#include "render/gl/gl_renderer.h"
#include "render/proxy/points_proxy.h"
#include "render/quality/choice.h"
#include "render/stereo/proxy_builder.h"
#include "tests/charts/studio_views.h"
#include "tests/measure/runner.h"
#include "tests/measure/table.h"
#include "tests/support/floors.h"

namespace ulf::test {
namespace {

using Eigen::Vector3f;

// Vertices that share a cube of `edge` become their mean; triangles that lose a corner go.
TriangleMesh Clustered(const TriangleMesh& mesh, float edge) {
  std::map<std::array<int, 3>, std::uint32_t> number_of;
  std::vector<std::uint32_t> number;
  std::vector<int> members;
  TriangleMesh coarse;
  for (const Vector3f& vertex : mesh.vertices) {
    const Vector3f cell = (vertex / edge).array().floor();
    const auto [at, is_new] = number_of.try_emplace(
        {static_cast<int>(cell.x()), static_cast<int>(cell.y()), static_cast<int>(cell.z())},
        static_cast<std::uint32_t>(coarse.vertices.size()));
    if (is_new) coarse.vertices.push_back(Vector3f::Zero()), members.push_back(0);
    coarse.vertices[at->second] += vertex;
    ++members[at->second];
    number.push_back(at->second);
  }
  for (std::size_t i = 0; i < members.size(); ++i) coarse.vertices[i] /= static_cast<float>(members[i]);
  for (const auto& [a, b, c] : mesh.triangles)
    if (number[a] != number[b] && number[b] != number[c] && number[c] != number[a])
      coarse.triangles.push_back({number[a], number[b], number[c]});
  return coarse;
}

std::string Thousands(std::size_t count) {
  return count < 1000 ? std::to_string(count) : fmt::format("{:.3g}k", static_cast<double>(count) / 1000);
}

constexpr char kDisc[] = "the subject (its sphere's silhouette)", kFrame[] = "the whole frame";

struct Tried {
  std::string series, name;
  std::shared_ptr<const Proxy> proxy;
  bool offered = false;       // to --proxy auto
  std::size_t triangles = 0;  // of a mesh
};

// Names say how many points and triangles are asked for or kept, so that those of all seeds are one row.
std::vector<Tried> Proxies(const RenderScene& scene, unsigned seed, const Effort& effort) {
  std::vector<Tried> tried{{"plane", "plane", std::make_shared<PlaneProxy>(scene.subject), true}};
  for (const int count : effort.Of(std::vector{1000}, {100, 1000, 3000, 30000}))
    tried.push_back({"true points, 0.2 % of the depth off", Thousands(static_cast<std::size_t>(count)),
                     std::make_shared<PointsProxy>(scene.subject, StudioPoints({.seed = seed}, count)),
                     count == effort.Of(1000, 3000)});
  const TriangleMesh mesh = BuildProxy(scene, {.size_px = 480, .depth_maps = effort.Of(8, 40)}).mesh;
  for (const double edge_m : effort.Of(std::vector{0.02}, {0.2, 0.05, 0.0125, 0.0})) {
    const auto coarse =
        std::make_shared<TriangleMesh>(edge_m > 0 ? Clustered(mesh, static_cast<float>(edge_m)) : mesh);
    tried.push_back({"mesh of ulf proxy, clustered",
                     edge_m > 0 ? fmt::format("cubes of {:g} mm", 1000 * edge_m) : "whole",
                     std::make_shared<MeshProxy>(scene.subject, coarse), edge_m == 0,
                     coarse->triangles.size()});
  }
  return tried;
}

Chart MeasureProxies(const Effort& effort) {
  Table table;
  std::string found;
  for (const char* title : {kDisc, kFrame})
    table.Panel(title, Log("a picture [ms, CPU]"), MoreIsBetter({"PSNR [dB]"}));
  for (const unsigned seed : effort.Seeds(3)) {
    const auto scene = StudioScene({.seed = seed, .threshold_px = effort.Of(24.0, 12.0)});
    const auto truth = StudioTruth({.seed = seed}, effort.Of(6, 12));
    const auto renderer = MakeRenderer(scene, {});
    const std::vector<Tried> tried = Proxies(*scene, seed, effort);
    std::vector<std::shared_ptr<const Proxy>> offered;
    for (const Tried& one : tried)
      if (one.offered) offered.push_back(one.proxy);
    const auto chosen =
        ChooseByEvidence(*scene, {{.kind = FieldKind::kSubdivision}}, offered, RendererKind::kGl).proxy;
    for (const Tried& one : tried) {
      renderer->SetProxy(one.proxy);
      const RenderedQuality quality = MeasureRendering(*renderer, truth);
      if (seed == kFirstSeed && one.triangles > 0)
        found += fmt::format("{}{}: {}", found.empty() ? "Triangles of the first seed: " : ", ", one.name,
                             Thousands(one.triangles));
      table.Add(kDisc, one.series, one.name, quality.cpu_ms, quality.psnr_disc_db, one.proxy == chosen);
      table.Add(kFrame, one.series, one.name, quality.cpu_ms, quality.psnr_db, one.proxy == chosen);
    }
  }
  return {.found = found, .panels = table.panels()};
}

CHART(proxies, MeasureProxies, "Geometry: where more of it stops helping", R"(The simulated studio, three
  seeds, views for a threshold of 12 px, subdivision weights, 480 x 320 pixels; 12 pictures of each seed
  from places that were not recorded. Names are numbers of points, and cubes whose vertices become one.
  Processor time, reading the picture back included; bars: lowest to highest seed. Ringed: what `--proxy
  auto` takes, for most seeds, of the plane, 3,000 points and the whole mesh.)");

}  // namespace
}  // namespace ulf::test
