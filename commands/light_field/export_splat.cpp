// `ulf export splat`: Gaussians of a light field in one file, for viewers and editors of others.
#include <fmt/core.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "commands/light_field/export_scene.h"
#include "commands/options/scene_options.h"
#include "commands/options/subcommands.h"
#include "core/base/at.h"
#include "core/base/atomic_file.h"
#include "core/base/counted.h"
#include "core/base/error.h"
#include "core/base/json_text.h"
#include "core/base/output_path.h"
#include "core/base/progress.h"
#include "core/base/shell_word.h"
#include "core/base/stop_signal.h"
#include "core/light_field/exchange/export_light_field.h"
#include "core/light_field/folder/light_field_io.h"
#include "render/proxy/depth_map_files.h"
#include "render/proxy/mesh_file.h"
#include "render/proxy/proxy_choice.h"
#include "render/proxy/soft_proxy.h"
#include "render/splats/make_splats.h"
#include "render/splats/splat_files.h"
#include "render/splats/spz_file.h"
#include "render/stereo/proxy_builder.h"

namespace ulf::commands {
namespace {

struct SplatArgs : SceneArgs {
  std::string output;
  int most = 1000000;
  bool json = false;
};

std::string EndingOf(const std::string& output) {
  std::string ending = std::filesystem::path(output).extension().string();
  std::ranges::transform(ending, ending.begin(), [](unsigned char c) { return std::tolower(c); });
  if (ending != ".ply" && ending != ".spz" && ending != ".glb")
    throw UsageError("--output {}: the file's ending says the format: .ply, .spz or .glb", output);
  return ending;
}

std::string BytesOf(const std::string& ending, const render::Gaussians& gaussians,
                    const render::RenderScene& scene, const LightField& light_field) {
  if (ending == ".ply") return render::SplatPlyBytes(gaussians);
  if (ending == ".spz") return render::SpzBytes(gaussians);
  return render::SplatGlbBytes(gaussians, scene.up_in_world,
                               std::filesystem::weakly_canonical(light_field.root).filename().string(),
                               light_field.units);
}

void Report(const SplatArgs& args, const render::Splats& splats, const std::string& geometry,
            std::size_t bytes) {
  if (args.json) {
    const nlohmann::ordered_json json{{"output", args.output},
                                      {"gaussians", splats.gaussians.size()},
                                      {"around", splats.around},
                                      {"views", splats.views},
                                      {"psnr_db", splats.psnr_db},
                                      {"geometry", geometry},
                                      {"bytes", bytes}};
    fmt::print("{}\n", JsonText(json, 2));
    return;
  }
  fmt::print("{}: {}, {} of them around the scene for what lies beyond its depth maps; {:.1f} MB\n",
             args.output, Counted(splats.gaussians.size(), "Gaussian"), splats.around,
             1e-6 * static_cast<double>(bytes));
  fmt::print("their pictures of {} differ from the photographs by {:.1f} dB\n",
             Counted(At(splats.views), "view"), splats.psnr_db);
}

// Depth maps and mesh of photographs that have none yet; the light field stays as it is.
std::shared_ptr<const render::Proxy> MakeGeometry(const SplatArgs& args, const LightField& light_field,
                                                  const Subject& subject) {
  render::RequireViewsForMesh(light_field, args.dir, 0);
  spdlog::info("{} has no geometry yet, so it is made first; to keep it: ulf proxy {}", args.dir,
               ShellWord(args.dir));
  const render::ProxyOptions options{.keep_maps = true};
  const auto scene = render::LoadForGeometry(light_field, OptionsOf(args), options.size_px);
  Progress progress("geometry", args.json);
  render::ProxyMesh made = render::BuildProxy(*scene, options, &progress);
  return std::make_shared<render::SoftProxy>(
      subject, std::make_shared<const render::TriangleMesh>(std::move(made.mesh)),
      render::SoftProxy::InMemory(std::move(made.maps)));
}

std::shared_ptr<const render::Proxy> GeometryOf(const SplatArgs& args, const LightField& light_field,
                                                const Subject& subject) {
  if (render::HasDepthMaps(light_field.root)) return render::OwnProxy("soft", subject, args.dir);
  if (!std::filesystem::exists(light_field.root / render::kMeshProxyFile))
    return MakeGeometry(args, light_field, subject);
  spdlog::info("depth maps give better Gaussians than the mesh alone; make them with: ulf proxy {}",
               ShellWord(args.dir));
  return render::OwnProxy("mesh", subject, args.dir);
}

int RunSplat(const SplatArgs& args) {
  const std::string ending = EndingOf(args.output);
  const LightField light_field = ReadLightField(args.dir);
  RequireWritable(args.output);
  RequireUnused(args.output);
  RequireOutside(light_field.root, args.output);
  const Subject subject = render::SubjectOf(light_field, OptionsOf(args).subject);
  const auto proxy = GeometryOf(args, light_field, subject);
  std::shared_ptr<const render::RenderScene> scene = render::LoadScene(light_field, OptionsOf(args));
  if (const auto light = LightOf(args, *scene, proxy)) scene = render::WithLight(*scene, *light);
  scene = render::WithProxy(*scene, proxy);
  const StopOnSignal signals;
  Progress progress("export", args.json);
  const render::Splats splats = render::MakeSplats(
      *scene,
      {.most = static_cast<std::size_t>(args.most), .progress = [&](double share, const std::string& what) {
         if (StopOnSignal::Requested()) throw Error("stopped before the end, as asked; nothing was exported");
         progress.Show(share, what);
       }});
  const std::string bytes = BytesOf(ending, splats.gaussians, *scene, light_field);
  WriteFileAtomically(args.output, bytes);
  Report(args, splats, proxy->Name(), bytes.size());
  return kOk;
}

}  // namespace

void AddExportSplat(CLI::App& command, ChosenCommand& chosen) {
  const auto [splat, args] = NewSubcommand(
      command, chosen, "splat",
      "Gaussians (splats) made of the depth maps without training, for viewers and editors of splats",
      RunSplat);
  splat->add_option("DIR", args->dir, "Light field, or a set with transforms.json")->required();
  splat->add_option("-o,--output", args->output, "New file, .ply, .spz or .glb")->required();
  splat->add_option("--most", args->most, "Most Gaussians; fewer are coarser (1000000)")
      ->check(CLI::Range(1000, 20000000));
  splat->add_option("--subject", args->subject,
                    "Centre and radius x,y,z,r of the subject (the light field's)");
  splat->add_flag("--json", args->json, "Print one JSON object");
  splat->footer("Example: ulf export splat vase -o vase.spz");
}

}  // namespace ulf::commands
