// How good pictures are and what they cost: left-out views of several light fields, every blending field over
// the plane and over the mesh that was made without them.
//
//   render_quality FOLDER [SET...]
//
// A set is `simulator`, or shop_grid_even, fox_half and temple_ring of the test data; without any, all that
// are found (photographs of shop_grid_even at two thirds of their size). FOLDER gets the meshes (one that is
// there already is taken as it is), quality.json, and quality.svg: PSNR over the time of a picture. The table
// and, a line each, what the figures are to be (and whether they are) go to standard output. Lumigraph
// weights are those per pixel, of four and of eight views.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>

#include "acquisition/simulator/simulated_camera.h"
#include "commands/options/command_line.h"
#include "core/base/error.h"
#include "core/base/json_text.h"
#include "core/base/progress.h"
#include "core/light_field/folder/light_field_io.h"
#include "core/light_field/folder/light_field_writer.h"
#include "render/fields/field_options.h"
#include "render/proxy/mesh_file.h"
#include "render/quality/choice.h"
#include "render/quality/evaluate.h"
#include "render/stereo/proxy_builder.h"
#include "tests/charts/plot/chart.h"
#include "tests/support/floors.h"
#include "tests/support/pose_readers.h"
#include "tests/support/test_paths.h"

namespace {

using namespace ulf;
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

std::vector<FieldOptions> AllFields() {
  std::vector<FieldOptions> fields;
  for (const auto& [name, field] : Fields()) fields.push_back(field);
  return fields;
}

struct Set {
  std::string name;
  LightField light_field;
  SceneOptions options;
};

// A scan of the simulated studio with the sensor's noise and exact poses.
LightField Simulated(const fs::path& dir) {
  if (fs::exists(dir)) return ReadLightField(dir);
  const SimulatedCamera camera(SimulationOptions::FromUri(DeviceUri::Parse(kSimulated)));
  CaptureHeader header;
  header.camera = camera.camera();
  auto writer = LightFieldWriter::Create(dir, header);
  constexpr int kViews = 200, kFramesBetween = 6;
  for (int i = 0; i < kViews; ++i) {
    const Frame frame = camera.Capture(static_cast<std::uint64_t>(i) * kFramesBetween);
    View view;
    view.cam_from_world = frame.known_cam_from_world.value();
    writer.AddView(frame, view);
  }
  writer.SetSubject(camera.scene().subject());
  writer.SetUp(Eigen::Vector3d::UnitZ());
  writer.Close(1);
  return ReadLightField(dir);
}

std::optional<Set> Find(const std::string& name, const fs::path& work) {
  Set set;
  set.name = name;
  if (name == "simulator") {
    set.light_field = Simulated(work / name);
    return set;
  }
  const auto dir = test::TestData(name);
  if (!dir) return std::nullopt;
  set.light_field =
      name == "temple_ring" ? test::MiddleburyLightField(*dir, "templeR_par.txt") : ReadLightField(*dir);
  if (name == "shop_grid_even") set.options = {.subject = Subject{{0, 0, -8.12}, 1.5}, .size_limit_px = 640};
  return set;
}

// Made without the views that are left out.
std::shared_ptr<const Proxy> Mesh(const Set& set, const RenderScene& scene, const fs::path& work,
                                  nlohmann::json& report) {
  const fs::path file = work / (set.name + ".ply");
  if (!fs::exists(file)) {
    Progress progress("mesh of " + set.name);
    SceneOptions options = set.options;
    const ProxyOptions proxy;
    options.size_limit_px = proxy.size_px;
    for (int i = 0; i < static_cast<int>(set.light_field.views.size()); i += kEvery)
      options.leave_out.push_back(i);
    WriteMeshPly(file, BuildProxy(*LoadScene(set.light_field, options), proxy, &progress).mesh);
  }
  auto mesh = std::make_shared<TriangleMesh>(ReadMeshFile(file).mesh);
  report["triangles"] = mesh->triangles.size();
  return std::make_shared<MeshProxy>(scene.subject, mesh);
}

// Of a proxy by a field.
struct Cell {
  double inside_db = 0, all_db = 0, ssim = 0, ms = 0;
  int inside_views = 0;
  bool asked = true;    // or another field, where the viewpoints do not allow it
  bool chosen = false;  // by --field auto, which does not see the views that are left out here
};
// By proxy and field.
using Table = std::map<std::string, std::map<std::string, Cell>>;

// What `ulf render --field auto` takes over each of the proxies.
void MarkChoices(const Set& set, const RenderScene& scene,
                 const std::vector<std::shared_ptr<const Proxy>>& proxies, Table& table) {
  std::vector<int> left_out;
  for (int i = 0; i < static_cast<int>(set.light_field.views.size()); i += kEvery) left_out.push_back(i);
  const auto rest = Without(scene, left_out);
  for (const auto& proxy : proxies) {
    const Choice choice = ChooseByEvidence(
        *rest,
        {{.kind = FieldKind::kSubdivision}, {.kind = FieldKind::kLinear}, {.kind = FieldKind::kLumigraph}},
        {proxy}, RendererKind::kGl);
    for (const auto& [name, field] : Fields())
      if (field.kind == choice.field.kind && field.level == choice.field.level)
        table[proxy->Name()][name].chosen = true;
  }
}

Table Measure(const Set& set, const fs::path& work, nlohmann::json& report) {
  const auto scene = LoadScene(set.light_field, set.options);
  const std::vector<std::shared_ptr<const Proxy>> proxies{std::make_shared<PlaneProxy>(scene->subject),
                                                          Mesh(set, *scene, work, report)};
  Progress progress(set.name);
  const EvaluateSummary summary =
      Evaluate(*scene, {.every = kEvery, .fields = AllFields(), .proxies = proxies}, &progress);
  Table table;
  for (std::size_t i = 0; i < summary.results.size(); ++i) {
    const FieldScore& score = summary.results[i];
    const MeanScore& inside = score.inside.views > 0 ? score.inside : score.all;
    table[score.proxy][Fields()[i % Fields().size()].first] = {.inside_db = inside.psnr_db,
                                                               .all_db = score.all.psnr_db,
                                                               .ssim = inside.ssim,
                                                               .ms = score.ms_per_frame,
                                                               .inside_views = score.inside.views,
                                                               .asked = score.asked.kind == score.used.kind};
  }
  MarkChoices(set, *scene, proxies, table);
  report["views"] = summary.views;
  report["held_out"] = summary.held_out;
  report["width_px"] = summary.width;
  report["height_px"] = summary.height;
  report["renderer"] = summary.renderer;
  report["viewpoints"] = summary.viewpoints;
  for (const auto& [proxy, row] : table)
    for (const auto& [field, cell] : row) {
      report["results"][proxy][field] = {{"psnr_db", cell.all_db},
                                         {"psnr_inside_db", cell.inside_db},
                                         {"views_inside", cell.inside_views},
                                         {"ssim_inside", cell.ssim},
                                         {"ms", cell.ms},
                                         {"as_asked", cell.asked},
                                         {"chosen", cell.chosen}};
    }
  return table;
}

void Print(const Set& set, const Table& table, const nlohmann::json& report) {
  fmt::print(
      "\n{}: {} views, {} left out ({} inside the hull), {}x{}, mesh of {} triangles\n{:<6} {:<18} {:>8} "
      "{:>8} {:>7} {:>8}\n",
      set.name, report["views"].get<int>(), report["held_out"].get<int>(),
      table.begin()->second.begin()->second.inside_views, report["width_px"].get<int>(),
      report["height_px"].get<int>(), report["triangles"].get<int>(), "proxy", "field", "dB", "inside",
      "SSIM", "ms");
  for (const auto& [proxy, row] : table)
    for (const auto& [name, field] : Fields()) {
      const Cell& cell = row.at(name);
      fmt::print("{:<6} {:<18} {:8.2f} {:8.2f} {:7.4f} {:8.1f}{}{}\n", proxy, name, cell.all_db,
                 cell.inside_db, cell.ssim, cell.ms, cell.chosen ? "  what --field auto takes" : "",
                 cell.asked ? "" : "  (not to be had here)");
    }
}

void Target(const std::string& what, double value, double at_least) {
  fmt::print("target {}: {:.2f}, {:.2f} or more wanted: {}\n", what, value, at_least,
             value >= at_least ? "reached" : "missed");
}

// The figures that are asked of a set.
void PrintTargets(const std::string& set, const Table& table) {
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

// Each set over each proxy a colour, what is chosen by --field auto ringed.
void DrawQuality(const std::vector<std::pair<std::string, Table>>& tables, const std::string& path) {
  std::vector<test::ChartRow> points;
  for (const auto& [set, table] : tables)
    for (const auto& [proxy, row] : table)
      for (const auto& [name, field] : Fields())
        if (const Cell& cell = row.at(name); cell.asked) {
          points.push_back({set + ", " + proxy, name, test::ChartSpread::Exactly(cell.ms),
                            test::ChartSpread::Exactly(cell.all_db), cell.chosen});
        }
  test::Chart chart{.name = "quality",
                    .title = "How good pictures of left-out views are, and what they cost",
                    .about = "Means over all left-out views; the default is what --field auto takes.",
                    .caption = {},
                    .panels = {}};
  chart.panels.push_back(
      {.title = {},
       .cost = {.label = "milliseconds a picture", .logarithmic = true},
       .error = {.label = "PSNR of left-out views, dB", .logarithmic = false, .more_is_better = true},
       .points = std::move(points),
       .compared = tables.size() == 1,
       .joined = false,
       .all_named = true});
  test::DrawChartFile(path, chart);
}

int Run(int argc, char** argv) {
  if (argc < 2) throw UsageError("usage: render_quality FOLDER [SET...]");
  const fs::path work = argv[1];
  fs::create_directories(work);
  std::vector<std::string> names(argv + 2, argv + argc);
  if (names.empty()) names = {"simulator", "shop_grid_even", "fox_half", "temple_ring"};
  nlohmann::json report;
  std::vector<std::pair<std::string, Table>> tables;
  for (const std::string& name : names) {
    const auto set = Find(name, work);
    if (!set) {
      fmt::print("{}: not among the test data\n", name);
      continue;
    }
    tables.emplace_back(name, Measure(*set, work, report[name]));
    Print(*set, tables.back().second, report[name]);
    PrintTargets(name, tables.back().second);
    std::fflush(stdout);
    std::ofstream(work / "quality.json") << JsonText(report, 1) << "\n";
  }
  if (!tables.empty()) DrawQuality(tables, (work / "quality.svg").string());
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return Run(argc, argv);
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 1;
  }
}
