#include <fmt/core.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "commands/options/command_line.h"
#include "commands/options/mesh_option.h"
#include "commands/options/scene_options.h"
#include "commands/options/subcommands.h"
#include "commands/reports/explain.h"
#include "commands/reports/work_reports.h"
#include "core/base/counted.h"
#include "core/base/host_time.h"
#include "core/base/json_text.h"
#include "core/base/lowercase.h"
#include "core/base/output_path.h"
#include "core/base/progress.h"
#include "core/light_field/exchange/export_light_field.h"
#include "core/light_field/folder/leftovers.h"
#include "core/light_field/folder/light_field_io.h"
#include "core/light_field/light_field.h"
#include "render/fields/field_options.h"
#include "render/proxy/depth_map_files.h"
#include "render/proxy/geometry_state.h"
#include "render/proxy/mesh_file.h"
#include "render/proxy/mesh_resolution.h"
#include "render/proxy/proxy_choice.h"
#include "render/quality/choice.h"
#include "render/stereo/proxy_builder.h"

namespace ulf::commands {
namespace {

struct ProxyArgs {
  std::string dir;
  std::string subject;
  std::string from;
  std::string out;
  int leave_out_every = 0;
  std::string maps;        // the folder of swept maps
  std::string maps_of;     // the share to sweep; empty: fuse all
  int most_triangles = 0;  // 0: those of `options` or, of a mesh of another program, as many as pictures show
  render::ProxyOptions options;
  std::string renderer = "auto";
  bool no_maps = false;
  bool explain = false;
  bool json = false;
};

void Print(const ProxyArgs& args, const render::ProxyMesh& proxy, const std::string& out, double seconds) {
  const render::ProxySummary& summary = proxy.summary;
  if (args.json) {
    const nlohmann::json report{{"output", out},
                                {"views", summary.views},
                                {"depth_maps", summary.depth_maps},
                                {"agreeing_share", summary.agreeing_share},
                                {"points", summary.points},
                                {"pixel_depth_radii", summary.pixel_depth_radii},
                                {"vertices", proxy.mesh.vertices.size()},
                                {"triangles", proxy.mesh.triangles.size()},
                                {"device", summary.device},
                                {"seconds", seconds},
                                {"sweep_s", summary.sweep_s},
                                {"fusion_s", summary.fusion_s},
                                {"surface_s", summary.surface_s},
                                {"peak_mib", PeakMemoryMib()}};
    fmt::print("{}\n", JsonText(report, 1));
    return;
  }
  if (summary.depth_maps > 0)
    fmt::print("{}, {} of them with a depth map, {:.0f} % of whose pixels others confirm: {}\n",
               Counted(summary.views, "view"), summary.depth_maps, 100 * summary.agreeing_share,
               Counted(summary.points, "point"));
  fmt::print("{}: {}, {:.1f} s (depth maps {:.1f}, fusion {:.1f}, surface {:.1f}), {:.0f} MiB\n", out,
             Counted(proxy.mesh.triangles.size(), "triangle"), seconds, summary.sweep_s, summary.fusion_s,
             summary.surface_s, PeakMemoryMib());
}

render::ProxyMesh Imported(const ProxyArgs& args, const LightField& light_field) {
  render::MeshReading reading = render::ReadMeshFile(args.from);
  if (const std::string dropped = reading.Dropped(); !dropped.empty())
    spdlog::warn("{}: {}", args.from, dropped);
  const std::size_t triangles = reading.mesh.triangles.size();
  const std::size_t most =
      args.most_triangles > 0 ? static_cast<std::size_t>(args.most_triangles) : render::kMostTrianglesShown;
  render::TriangleMesh mesh = render::Simplified(reading.mesh, light_field.subject, most);
  if (mesh.triangles.size() < triangles)
    spdlog::info("{}: made coarser from {} to {}, {} (--triangles)", args.from,
                 Counted(triangles, "triangle"), mesh.triangles.size(),
                 args.most_triangles > 0 ? "as asked" : "because pictures show no more");
  RequireMeshOfLightField(args.from, mesh, args.dir);
  return {std::move(mesh), {}, {}};
}

std::shared_ptr<const render::RenderScene> SceneFor(const ProxyArgs& args, const LightField& light_field) {
  render::SceneOptions scene_options;
  if (!args.subject.empty()) scene_options.subject = ParseSubject(args.subject);
  if (args.leave_out_every > 0)
    for (std::size_t i = 0; i < light_field.views.size(); i += static_cast<std::size_t>(args.leave_out_every))
      scene_options.leave_out.push_back(static_cast<int>(i));
  render::RequireViewsForMesh(light_field, args.dir, scene_options.leave_out.size());
  return render::LoadForGeometry(light_field, scene_options, args.options.size_px);
}

render::ProxyMesh Built(const ProxyArgs& args, const LightField& light_field) {
  const auto scene = SceneFor(args, light_field);
  Progress progress("proxy");
  render::ProxyOptions options = args.options;
  options.keep_maps = args.out.empty() && !args.no_maps;
  if (args.maps.empty()) return render::BuildProxy(*scene, options, &progress);
  const render::SweptMapFiles maps = render::FindSweptMaps(args.maps, render::SweepDigest(*scene, options));
  return render::BuildProxyOf(maps, *scene, options, &progress);
}

int SweepMaps(const ProxyArgs& args, const LightField& light_field) {
  const auto start = std::chrono::steady_clock::now();
  const render::MapShare share = render::MapShare::Parse(args.maps_of);
  RequireOutside(light_field.root, args.maps, "maps");
  RequireWritableFolder(args.maps);
  const auto scene = SceneFor(args, light_field);
  Progress progress("proxy");
  // Computed before the photographs are compared: one that changes meanwhile must not count as compared.
  const std::uint64_t digest = render::SweepDigest(*scene, args.options);
  const render::SweptMaps maps = render::SweepShare(*scene, args.options, share, &progress);
  render::WriteSweptMaps(args.maps, share, digest, maps);
  const double seconds = SecondsSince(start);
  if (args.json)
    fmt::print("{}\n", JsonText(nlohmann::json{{"output", args.maps},
                                               {"share", share.index},
                                               {"of", share.of},
                                               {"depth_maps", maps.size()},
                                               {"seconds", seconds},
                                               {"peak_mib", PeakMemoryMib()}},
                                1));
  else
    fmt::print("{}: share {} of {}, {}, {:.1f} s\n", args.maps, share.index, share.of,
               Counted(maps.size(), "depth map"), seconds);
  return kOk;
}

// Compares the mesh with the other proxies on left-out views.
void Explain(const ProxyArgs& args, const LightField& light_field, const std::string& mesh_file) {
  render::SceneOptions options;
  if (!args.subject.empty()) options.subject = ParseSubject(args.subject);
  const auto scene = render::LoadScene(light_field, options);
  std::vector<std::shared_ptr<const render::Proxy>> proxies{
      render::ProxyFromName("plane", scene->subject, args.dir)};
  for (const std::string& name : render::OwnProxies(args.dir))
    if (name != "mesh" && name != "soft")
      proxies.push_back(render::ProxyFromName(name, scene->subject, args.dir));
  proxies.push_back(render::ProxyFromName(mesh_file, scene->subject, args.dir));
  const render::Choice choice =
      render::ChooseByEvidence(*scene, {render::FieldOptions{}}, proxies, RendererFromName("auto"));
  LogExplanation(true, false, choice.why, choice.explained);
  if (args.leave_out_every == 0)
    fmt::print(stderr, "(the mesh was made with the left-out views, too, and scores a little too well)\n");
}

void WriteOwnGeometry(const LightField& light_field, const render::ProxyMesh& proxy,
                      const std::vector<std::string>& origin) {
  RemoveLeftovers(light_field.root, false);
  // A mesh that ulf did not make cannot be made again.
  const auto there = render::GeometryStateOf(light_field);
  const bool keeps = there && !there->origin;
  const render::KeptGeometry kept =
      render::WriteGeometryFiles(light_field, render::MeshPlyBytes(proxy.mesh, origin), proxy.maps,
                                 keeps ? render::FormerGeometry::kKept : render::FormerGeometry::kReplaced);
  if (kept.mesh)
    spdlog::info("the mesh that was there does not tell that ulf made it: it is kept as {}",
                 kept.mesh->string());
}

int RunProxy(const ProxyArgs& args) {
  const auto start = std::chrono::steady_clock::now();
  const std::string out =
      args.out.empty() ? (std::filesystem::path(args.dir) / render::kMeshProxyFile).string() : args.out;
  if (Lowercase(std::filesystem::path(out).extension().string()) != ".ply")
    throw UsageError("-o {}: a mesh is written as PLY; give a name ending in .ply", out);
  const LightField light_field = ReadLightField(args.dir);
  if (!args.maps_of.empty()) return SweepMaps(args, light_field);
  RequireWritable(out);
  const render::ProxyMesh proxy = args.from.empty() ? Built(args, light_field) : Imported(args, light_field);
  const bool tells_views = args.from.empty() && args.leave_out_every == 0;
  const auto origin =
      tells_views ? render::OriginComments("ulf proxy", light_field) : std::vector<std::string>{};
  if (args.out.empty())
    WriteOwnGeometry(light_field, proxy, origin);
  else
    render::WriteMeshPly(out, proxy.mesh, origin);
  if (proxy.summary.pixel_depth_radii > render::kRoughPixelRadii)
    spdlog::warn(
        "the views stand close together: a pixel between them is worth {:.1f} of the subject's radius in "
        "depth, and the mesh is rough; views from farther apart make it better",
        proxy.summary.pixel_depth_radii);
  Print(args, proxy, out, SecondsSince(start));
  if (args.explain) Explain(args, light_field, out);
  return kOk;
}

}  // namespace

void AddProxyCommand(CLI::App& app, ChosenCommand& chosen) {
  const auto args = std::make_shared<ProxyArgs>();
  CLI::App* sub = app.add_subcommand(
      "proxy", "Builds a triangle mesh of the scene, and depth maps of its views, for rendering");
  sub->add_option("dir", args->dir, "The light field: a folder with a journal or a transforms.json")
      ->required();
  sub->add_option("-o,--output", args->out, "PLY file to write (DIR/proxy.ply)");
  sub->add_option("--from", args->from,
                  "Copy this mesh (PLY or OBJ, in the light field's world) in place of building one");
  sub->add_option("--subject", args->subject, "Centre and radius x,y,z,r of the subject (the light field's)");
  sub->add_option("--leave-out-every", args->leave_out_every,
                  "Do not use every k-th view: those that ulf evaluate --every k leaves out (none)")
      ->check(CLI::Range(2, 1000000));
  sub->add_option("--size", args->options.size_px,
                  "Longer side of the photographs that are compared, in pixels")
      ->check(CLI::Range(32, 4096))
      ->capture_default_str();
  sub->add_option("--depth-maps", args->options.depth_maps, "Largest number of views that get a depth map")
      ->check(CLI::Range(2, 60000))
      ->capture_default_str();
  sub->add_option("--neighbours", args->options.neighbours,
                  "Number of views with which each of them is compared")
      ->check(CLI::Range(1, 32))
      ->capture_default_str();
  sub->add_option("--triangles", args->most_triangles,
                  "Largest number of triangles, about (400000; with --from 1000000)")
      ->check(CLI::Range(100, 20000000));
  auto* maps = sub->add_option(
      "--maps", args->maps,
      "Fuse the depth maps of this folder, which --maps-of made, in place of comparing photographs");
  sub->add_option("--maps-of", args->maps_of,
                  "K/N: only make the depth maps of share K of N (from 0), in the folder --maps; for several "
                  "computers (docs/farm.md)")
      ->needs(maps);
  sub->add_option(
         "--renderer", args->renderer,
         "What compares photographs: gl (OpenGL without a window), reference or auto (the processor)")
      ->check(CLI::IsMember({"auto", "gl", "reference"}));
  sub->add_flag("--no-maps", args->no_maps,
                "Write the mesh alone; otherwise DIR/depth gets the views' depth maps, for --proxy soft "
                "(with -o never)");
  sub->add_flag("--explain", args->explain, "Compare plane, points and mesh on left-out views");
  sub->add_flag("--json", args->json, "Report as one JSON object");
  sub->footer("Example: ulf proxy lightfield --leave-out-every 8 -o proxy.ply");
  sub->callback([&chosen, args] {
    args->options.device =
        args->renderer == "gl" ? render::SweepDevice::kGl : render::SweepDevice::kProcessor;
    if (args->most_triangles > 0) args->options.mesh.most_triangles = args->most_triangles;
    chosen = [args] { return RunProxy(*args); };
  });
}

}  // namespace ulf::commands
