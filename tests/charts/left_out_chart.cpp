// How good pictures are and what they cost: left-out views of several light fields, every blending field over
// the plane and over the mesh that was made without them. Sets of the test data that are not found are left
// out (photographs of shop_grid_even at two thirds of their size). What the figures are to be, and whether
// they are, goes to standard output, a line each. Lumigraph weights are those per pixel, of four and of eight
// views.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>
#include <optional>

#include "core/base/progress.h"
#include "render/fields/field_options.h"
#include "render/quality/choice.h"
#include "render/quality/evaluate.h"
#include "render/stereo/proxy_builder.h"
#include "tests/charts/left_out_sets.h"
#include "tests/measure/runner.h"
#include "tests/measure/table.h"
#include "tests/support/floors.h"
#include "tests/support/test_paths.h"

namespace ulf::test {
namespace {

namespace fs = std::filesystem;

constexpr int kEvery = 8;  // views between those that are left out
constexpr char kSimulated[] = "sim:studio?seed=7&look_away=0";

// In the order of columns.
const std::vector<std::pair<std::string, FieldOptions>>& Fields() {
  static const std::vector<std::pair<std::string, FieldOptions>> fields{
      {"nearest", {.kind = FieldKind::kNearest}},
      {"linear", {.kind = FieldKind::kLinear}},
      {"subdivision 1", {.kind = FieldKind::kSubdivision, .level = 1}},
      {"lumigraph", {.kind = FieldKind::kLumigraph}},
      {"lumigraph 4", {.kind = FieldKind::kLumigraphPerPixel, .lumigraph_k = 4}},
      {"lumigraph 8", {.kind = FieldKind::kLumigraphPerPixel, .lumigraph_k = 8}}};
  return fields;
}

using Set = LeftOutSet;

std::optional<Set> Find(const std::string& name, const fs::path& work) {
  if (name == "simulator") return Set{name, SimulatedScan({.uri = kSimulated}, work / name)};
  return FoundSet(name, work);
}

std::vector<int> LeftOut(const Set& set) { return EveryView(set.light_field, kEvery); }

// Made without the views that are left out.
std::shared_ptr<const TriangleMesh> Mesh(const Set& set) {
  Progress progress("mesh of " + set.name);
  SceneOptions options = set.options;
  const ProxyOptions proxy;
  options.size_limit_px = proxy.size_px;
  options.leave_out = LeftOut(set);
  return std::make_shared<TriangleMesh>(
      BuildProxy(*LoadScene(set.light_field, options), proxy, &progress).mesh);
}

// Holds what one field over one proxy shows of the left-out views.
struct Cell {
  double inside_db = 0, all_db = 0, ssim = 0, ms = 0;
  bool asked = true;    // or another field, where the viewpoints do not allow it
  bool chosen = false;  // by --field auto, which does not see the views that are left out here
};
// The keys are the proxy and the field.
using Cells = std::map<std::string, std::map<std::string, Cell>>;

// Marks the field that `ulf render --field auto` takes over each of the proxies.
void MarkChoices(const Set& set, const RenderScene& scene,
                 const std::vector<std::shared_ptr<const Proxy>>& proxies, Cells& cells) {
  const auto rest = Without(scene, LeftOut(set));
  for (const auto& proxy : proxies) {
    const Choice choice = ChooseByEvidence(
        *rest,
        {{.kind = FieldKind::kSubdivision}, {.kind = FieldKind::kLinear}, {.kind = FieldKind::kLumigraph}},
        {proxy}, RendererKind::kGl);
    for (const auto& [name, field] : Fields())
      if (field.kind == choice.field.kind && field.level == choice.field.level)
        cells[proxy->Name()][name].chosen = true;
  }
}

// `found` gets a sentence about the set.
Cells Measure(const Set& set, std::string& found) {
  const auto scene = LoadScene(set.light_field, set.options);
  const auto mesh = Mesh(set);
  const std::vector<std::shared_ptr<const Proxy>> proxies{std::make_shared<PlaneProxy>(scene->subject),
                                                          std::make_shared<MeshProxy>(scene->subject, mesh)};
  std::vector<FieldOptions> fields;
  for (const auto& [name, field] : Fields()) fields.push_back(field);
  Progress progress(set.name);
  const EvaluateSummary summary =
      Evaluate(*scene, {.every = kEvery, .fields = fields, .proxies = proxies}, &progress);
  Cells cells;
  for (std::size_t i = 0; i < summary.results.size(); ++i) {
    const FieldScore& score = summary.results[i];
    const MeanScore& inside = score.inside.views > 0 ? score.inside : score.all;
    cells[score.proxy][Fields()[i % Fields().size()].first] = {.inside_db = inside.psnr_db,
                                                               .all_db = score.all.psnr_db,
                                                               .ssim = inside.ssim,
                                                               .ms = score.ms_per_frame,
                                                               .asked = score.asked.kind == score.used.kind};
  }
  MarkChoices(set, *scene, proxies, cells);
  found += fmt::format(
      "{}{}: {} views ({}), {} left out, {} of them inside the hull, {}x{}, {}, mesh of {} triangles.",
      found.empty() ? "" : " ", set.name, summary.views, summary.viewpoints, summary.held_out,
      summary.results.front().inside.views, summary.width, summary.height, summary.renderer,
      mesh->triangles.size());
  return cells;
}

void Target(const std::string& what, double value, double at_least) {
  fmt::print("target {}: {:.2f}, {:.2f} or more wanted: {}\n", what, value, at_least,
             value >= at_least ? "reached" : "missed");
}

// The figures that are asked of a set.
void PrintTargets(const std::string& set, const Cells& table) {
  const auto& plane = table.at("plane");
  const auto& mesh = table.at("mesh");
  const Cell& on_plane = plane.at("subdivision 1");
  const Cell& on_mesh = mesh.at("subdivision 1");
  static const std::map<std::string, std::pair<double, double>> kWanted{{"shop_grid_even", {29.4, 34.5}},
                                                                        {"fox_half", {20.7, 25.5}}};
  if (const auto wanted = kWanted.find(set); wanted != kWanted.end()) {
    Target(set + ", plane, dB", on_plane.all_db, wanted->second.first);
    Target(set + ", mesh, dB", on_mesh.all_db, wanted->second.second);
  }
  if (set != "temple_ring") Target(set + ", mesh over plane, dB", on_mesh.all_db - on_plane.all_db, 4.5);
  for (const auto& [proxy, row] : table) {
    const double lumigraph = std::max(row.at("lumigraph 4").all_db, row.at("lumigraph 8").all_db);
    for (const auto& [name, cell] : row)
      if (name == "subdivision 1" || cell.chosen)
        Target(fmt::format("{}, {}, {} over the better lumigraph, dB", set, proxy, name),
               cell.all_db - lumigraph, -0.2);
  }
  if (on_mesh.asked)
    Target(set + ", mesh, inside the hull over both lumigraphs, dB",
           on_mesh.inside_db - std::max(mesh.at("lumigraph 4").inside_db, mesh.at("lumigraph 8").inside_db),
           0);
}

constexpr char kAll[] = "all left-out views", kInside[] = "those inside the hull of the others",
               kLikeness[] = "inside, likeness";

Chart MeasureLeftOut(const Effort& effort) {
  Table table;
  const auto panel = [&](const char* title, const char* error) {
    table.Panel(title, Log("milliseconds a picture"), MoreIsBetter({error}),
                {.compared = false, .joined = false, .all_named = true});
  };
  panel(kAll, "PSNR [dB]");
  panel(kInside, "PSNR [dB]");
  panel(kLikeness, "SSIM");
  std::string found;
  const ScratchFolder scratch;
  for (const std::string& name : effort.Of(std::vector<std::string>{"simulator"},
                                           {"simulator", "shop_grid_even", "fox_half", "temple_ring"})) {
    const auto set = Find(name, scratch.path());
    if (!set) {
      fmt::print("{}: not among the test data\n", name);
      continue;
    }
    const Cells cells = Measure(*set, found);
    PrintTargets(name, cells);
    for (const auto& [proxy, row] : cells)
      for (const auto& [field, of] : Fields())
        if (const Cell& cell = row.at(field); cell.asked) {
          const std::string series = name + ", " + proxy;
          table.Add(kAll, series, field, cell.ms, cell.all_db, cell.chosen);
          table.Add(kInside, series, field, cell.ms, cell.inside_db, cell.chosen);
          table.Add(kLikeness, series, field, cell.ms, cell.ssim, cell.chosen);
        }
  }
  return {.found = found, .panels = table.panels()};
}

CHART(left_out_views, MeasureLeftOut, "How good pictures of left-out views are, and what they cost", R"(Every
  eighth view is left out, also when the mesh is made. Means; fields that the viewpoints do not allow are
  left out. Ringed: what `--field auto` takes, which does not see these views.)",
      true);

}  // namespace
}  // namespace ulf::test
