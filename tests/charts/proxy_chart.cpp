// Where more geometry stops helping: the plane, tracked points in number, the light field's own mesh with
// ever fewer triangles.
#include <algorithm>
#include <array>
#include <map>

#include "render/fields/field_options.h"
#include "render/gl/gl_renderer.h"
#include "render/proxy/points_proxy.h"
#include "render/quality/choice.h"
#include "render/stereo/proxy_builder.h"
#include "tests/charts/makers.h"
#include "tests/charts/studio_views.h"
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

struct ProxyRow {
  std::string series, name;
  std::shared_ptr<const Proxy> offered;  // to --proxy auto; of the last seed
  int chosen = 0;                        // by it, of how many seeds
  std::vector<double> ms, disc_db, frame_db;
};

class Rows {
 public:
  // The same rows for every seed, in the same order.
  void BeginSeed() { next_ = 0; }
  void Add(const std::string& series, const std::string& name, std::shared_ptr<const Proxy> offered,
           const RenderedQuality& quality) {
    if (next_ == rows_.size()) rows_.push_back({series, name, nullptr, 0, {}, {}, {}});
    ProxyRow& row = rows_[next_++];
    row.offered = std::move(offered);
    row.ms.push_back(quality.cpu_ms);
    row.disc_db.push_back(quality.psnr_disc_db);
    row.frame_db.push_back(quality.psnr_db);
  }
  const std::vector<ProxyRow>& rows() const { return rows_; }
  void Choose(const RenderScene& scene) {
    std::vector<std::shared_ptr<const Proxy>> offered;
    for (const ProxyRow& row : rows_)
      if (row.offered) offered.push_back(row.offered);
    const Choice choice =
        ChooseByEvidence(scene, {{.kind = FieldKind::kSubdivision}}, offered, RendererKind::kGl);
    for (ProxyRow& row : rows_) row.chosen += row.offered == choice.proxy;
  }

 private:
  std::size_t next_ = 0;
  std::vector<ProxyRow> rows_;
};

std::string Thousands(std::size_t count) {
  return count < 1000 ? std::to_string(count) : fmt::format("{:.3g}k", static_cast<double>(count) / 1000);
}

}  // namespace

Chart ProxyChart(const ChartEffort& effort) {
  Rows rows;
  for (const unsigned seed : effort.Of(std::vector{1u}, {1u, 2u, 3u})) {
    rows.BeginSeed();
    const auto scene = StudioScene({.seed = seed, .threshold_px = effort.Of(24.0, 12.0)});
    const auto truth = StudioTruth({.seed = seed}, effort.Of(6, 12));
    const auto renderer = MakeRenderer(scene, {});
    const auto measure = [&](const std::string& series, const std::string& name, bool offered,
                             std::shared_ptr<const Proxy> proxy) {
      renderer->SetProxy(std::move(proxy));
      rows.Add(series, name, offered ? renderer->scene().proxy : nullptr, MeasureRendering(*renderer, truth));
    };
    measure("plane", "plane", true, std::make_shared<PlaneProxy>(scene->subject));
    for (const int count : effort.Of(std::vector{1000}, {100, 1000, 3000, 30000}))
      measure("true points, 0.2 % of the depth off", Thousands(static_cast<std::size_t>(count)),
              count == effort.Of(1000, 3000),
              std::make_shared<PointsProxy>(scene->subject, StudioPoints({.seed = seed}, count)));
    const TriangleMesh mesh = BuildProxy(*scene, {.size_px = 480, .depth_maps = effort.Of(8, 40)}).mesh;
    for (const double edge_m : effort.Of(std::vector{0.02}, {0.2, 0.05, 0.0125, 0.0})) {
      const auto coarse =
          std::make_shared<TriangleMesh>(edge_m > 0 ? Clustered(mesh, static_cast<float>(edge_m)) : mesh);
      measure("mesh of ulf proxy, clustered", Thousands(coarse->triangles.size()), edge_m == 0,
              std::make_shared<MeshProxy>(scene->subject, coarse));
    }
    rows.Choose(*scene);
  }
  Chart chart;
  chart.title = "Geometry: where more of it stops helping";
  chart.about =
      "The simulated studio, seeds 1 to 3 (made with seed 7), views for a threshold of 12 px, subdivision "
      "weights, 480 x 320 pixels; 12 pictures of each seed from places that were not recorded. Names are "
      "points and triangles (of seed 1). Processor time, reading the picture back included; bars: lowest to "
      "highest seed. Ringed: what `--proxy auto` takes, for most seeds, of the plane, 3,000 points and the "
      "whole mesh.";
  for (const bool disc : {true, false}) {
    ChartPanel panel{disc ? "the subject (its sphere's silhouette)" : "the whole frame",
                     {"a picture [ms, CPU]", true},
                     {"PSNR [dB]", false, true},
                     {}};
    for (const ProxyRow& row : rows.rows())
      panel.points.push_back({row.series, row.name, Spread::Of(row.ms),
                              Spread::Of(disc ? row.disc_db : row.frame_db),
                              2 * row.chosen > static_cast<int>(row.ms.size())});
    chart.panels.push_back(panel);
  }
  return chart;
}

}  // namespace ulf::test
