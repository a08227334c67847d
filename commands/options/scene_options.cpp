#include "commands/options/scene_options.h"

#include <spdlog/spdlog.h>

#include <cstdio>
#include <mutex>

#include "commands/options/command_line.h"
#include "commands/options/mesh_option.h"
#include "commands/options/option_values.h"
#include "core/base/error.h"
#include "core/light_field/folder/light_field_io.h"
#include "render/gl/gl_context.h"
#include "render/proxy/mesh_file.h"
#include "render/proxy/planes_proxy.h"
#include "render/proxy/proxy_choice.h"
#include "render/quality/choice.h"

namespace ulf::commands {

namespace {

// Says why there is no OpenGL; empty if there is one.
const std::string& MissingOpenGl() {
  static const std::string reason = [] {
    try {
      const render::GlContext context;
      return std::string();
    } catch (const Error& error) {
      return std::string(error.what());
    }
  }();
  return reason;
}

Eigen::Vector3d DirectionFromText(const std::string& text) {
  Eigen::Vector3d direction;
  int used = 0;
  if (std::sscanf(text.c_str(), "%lf,%lf,%lf%n", &direction.x(), &direction.y(), &direction.z(), &used) !=
          3 ||
      static_cast<std::size_t>(used) != text.size() || !(direction.norm() > 0) || !direction.allFinite())
    throw UsageError("--up {}: a direction is x,y,z, not of length 0, such as 0,0,1", text);
  return direction.normalized();
}

}  // namespace

render::RendererKind RendererFromName(const std::string& name) {
  if (name == "reference") return render::RendererKind::kReference;
  if (MissingOpenGl().empty()) return render::RendererKind::kGl;
  if (name == "gl") throw Error("{}, or use --renderer reference", MissingOpenGl());
  static std::once_flag warned;
  std::call_once(warned, [] {
    spdlog::warn("{}", MissingOpenGl());
    spdlog::warn(
        "the reference renderer draws the pictures, on the processor: the same pictures, but slowly");
  });
  return render::RendererKind::kReference;
}

render::SceneOptions OptionsOf(const SceneArgs& args) {
  render::SceneOptions options{.size_limit_px = args.size_limit_px,
                               .memory_limit_mb = args.memory_mb,
                               .form = args.form,
                               .mesh_in_plane = args.viewpoint_mesh == "plane"};
  if (!args.subject.empty()) options.subject = ParseSubject(args.subject);
  if (!args.up.empty()) options.up_in_world = DirectionFromText(args.up);
  return options;
}

std::shared_ptr<const render::RenderScene> Load(const SceneArgs& args) {
  render::SceneOptions options = OptionsOf(args);
  return render::LoadScene(ReadLightField(args.dir), options);
}

std::shared_ptr<const render::RenderScene> LoadMasks(const SceneArgs& args,
                                                     const render::RenderScene& scene) {
  if (!scene.is_cut_out) return nullptr;
  render::SceneOptions options = OptionsOf(args);
  options.of_masks = true;
  return render::LoadScene(ReadLightField(args.dir), options);
}

namespace {

bool StaysAsRecorded(const SceneArgs& args, const render::RenderScene& scene) {
  return args.light == "as-recorded" || (args.light == "auto" && scene.knows_exposures);
}

}  // namespace

std::shared_ptr<const render::Proxy> MeshForLight(
    const SceneArgs& args, const render::RenderScene& scene,
    const std::vector<std::shared_ptr<const render::Proxy>>& in_use) {
  if (StaysAsRecorded(args, scene)) return nullptr;
  for (const auto& proxy : in_use)
    if (proxy->Occluder() && proxy->Name() != render::kPlanesProxy) return proxy;
  if (!std::filesystem::exists(std::filesystem::path(args.dir) / render::kMeshProxyFile)) return nullptr;
  try {
    return render::ProxyFromName("mesh", scene.subject, args.dir);
  } catch (const Error& error) {
    spdlog::warn("light stays as it was recorded: {}", error.what());
    return nullptr;
  }
}

std::optional<render::LightFit> LightOf(const SceneArgs& args, const render::RenderScene& scene,
                                        const std::shared_ptr<const render::Proxy>& mesh) {
  if (StaysAsRecorded(args, scene)) return std::nullopt;
  if (!mesh || !mesh->Occluder()) {
    if (args.light == "fit")
      throw UsageError(
          "--light fit: only a mesh says where several views see the same; make one with ulf proxy");
    return std::nullopt;
  }
  render::LightFit fit = render::FitLight(*render::WithProxy(scene, mesh));
  spdlog::info("{}", fit.Words());
  return fit;
}

std::vector<std::shared_ptr<const render::Proxy>> Proxies(const SceneArgs& args,
                                                          const render::RenderScene& scene,
                                                          const render::FieldOptions& field) {
  if (args.proxies.empty()) return render::EveryProxyOf(args.dir, scene.subject);
  std::vector<std::shared_ptr<const render::Proxy>> proxies;
  for (const std::string& name : args.proxies) {
    RequireProxyOfLightField(name, args.dir);
    proxies.push_back(render::ProxyByName(scene, name, field, args.dir, RendererFromName(args.renderer),
                                          {.gpu_memory_mb = args.gpu_memory_mb}));
  }
  return proxies;
}

void AddSceneOptions(CLI::App& sub, SceneArgs& args) {
  sub.add_option("dir", args.dir, "The light field: a folder with a journal or a transforms.json")
      ->required();
  sub.add_option("--subject", args.subject, "Centre and radius x,y,z,r of the subject (the light field's)");
  sub.add_option("--up", args.up, "Up direction x,y,z for named paths and the viewer (that of the cameras)");
  sub.add_option("--size-limit", args.size_limit_px,
                 "Reduce photographs to this many pixels on the longer side (0: no reduction)")
      ->check(NonNegative());
  sub.add_option("--memory-mb", args.memory_mb,
                 "MB of photographs in main memory (2048); others are read again when needed")
      ->check(Positive());
  sub.add_option("--gpu-memory", args.gpu_memory_mb,
                 "MB of photographs in graphics memory (three quarters of what the driver says is free, or "
                 "2048); a picture that needs more is drawn in several passes")
      ->check(CLI::Range(1.0, 1e6));
  sub.add_option("--light", args.light,
                 "What views of a mesh differ by in exposure, and what lenses leave of light in their "
                 "corners: auto (found and evened out where the light field says nothing of exposures), fit "
                 "(found in any case), as-recorded (left as it is) (auto)")
      ->check(CLI::IsMember({"auto", "fit", "as-recorded"}));
  sub.add_option("--viewpoint-mesh", args.viewpoint_mesh,
                 "Triangulate viewpoints on the sphere, or in the plane of azimuth and elevation as in the "
                 "thesis, for comparison (sphere)")
      ->check(CLI::IsMember({"sphere", "plane"}));
  sub.add_option("--renderer", args.renderer,
                 "gl (OpenGL without a window), reference (slow) or auto (gl, or reference without OpenGL)")
      ->check(CLI::IsMember({"auto", "gl", "reference"}));
}

void AddFieldDetails(CLI::App& sub, FieldArgs& args) {
  sub.add_option("--level", args.level, "Levels of subdivision: 0 to 3 (1)")
      ->check(CLI::Range(0, render::kFinestLevel));
  sub.add_option("--subdivision", args.rules,
                 "Rules of subdivision: ulf (for Delaunay's triangles), or loop (Loop's and Warren's as "
                 "published, for comparison) (ulf)")
      ->check(CLI::IsMember({"ulf", "loop"}));
  sub.add_option("--lumigraph-views", args.lumigraph_k,
                 "Lumigraph weights: number of views (4; for views on a line 3)")
      ->check(CLI::Range(1, render::kMostLumigraphViews));
  sub.add_option("--lumigraph-resolution", args.lumigraph_resolution,
                 "Lumigraph weights: penalty in radians for a view twice as far away (0.1)")
      ->check(NonNegative());
  sub.add_option("--lumigraph-triangles", args.lumigraph_triangles,
                 "Lumigraph weights at vertices: number of triangles in the image (2000)")
      ->check(CLI::Range(100, 1000000));
  sub.add_option(
         "--soft-width", args.soft_width,
         "Soft field: how far the views' weights reach, in the angle of the fourth nearest view: 0.5 keeps "
         "highlights in place, 0.8 averages errors of poses and depth out (0.5; auto tries both)")
      ->check(CLI::Range(0.1, 4.0));
}

render::FieldOptions FieldDetails(const FieldArgs& args) {
  return {
      .level = args.level,
      .rules = args.rules == "loop" ? render::SubdivisionRules::kLoop : render::SubdivisionRules::kDelaunay,
      .lumigraph_k = args.lumigraph_k,
      .lumigraph_resolution = args.lumigraph_resolution,
      .lumigraph_triangles = args.lumigraph_triangles,
      .soft_width = args.soft_width};
}

}  // namespace ulf::commands
