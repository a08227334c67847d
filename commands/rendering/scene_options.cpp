#include "commands/rendering/scene_options.h"

#include <spdlog/spdlog.h>

#include <cstdio>

#include "commands/number_checks.h"
#include "core/base/error.h"
#include "core/light_field/light_field_io.h"
#include "render/gl/gl_context.h"
#include "render/proxy/proxy_choice.h"

namespace ulf::commands {

namespace {

render::RendererKind WhatThereIs() {
  try {
    const render::GlContext context;
    return render::RendererKind::kGl;
  } catch (const Error& error) {
    spdlog::warn("{}", error.what());
    spdlog::warn("pictures are drawn by the reference renderer, on the processor: the same ones, slowly");
    return render::RendererKind::kReference;
  }
}

render::RendererKind Insisted() {
  try {
    const render::GlContext context;
    return render::RendererKind::kGl;
  } catch (const Error& error) {
    throw Error("{}, or do without: --renderer reference", error.what());
  }
}

}  // namespace

render::RendererKind RendererFromName(const std::string& name) {
  if (name == "reference") return render::RendererKind::kReference;
  if (name == "gl") {
    static const render::RendererKind insisted = Insisted();
    return insisted;
  }
  static const render::RendererKind what_there_is = WhatThereIs();
  return what_there_is;
}

namespace {

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

std::shared_ptr<const render::RenderScene> Load(const SceneArgs& args) {
  render::SceneOptions options{.size_limit_px = args.size_limit_px,
                               .memory_limit_mb = args.memory_mb,
                               .form = args.form,
                               .mesh_in_plane = args.viewpoint_mesh == "plane"};
  if (!args.subject.empty()) options.subject = ParseSubject(args.subject);
  if (!args.up.empty()) options.up_in_world = DirectionFromText(args.up);
  return render::LoadScene(ReadLightField(args.dir), options);
}

std::vector<std::shared_ptr<const render::Proxy>> Proxies(const SceneArgs& args, const Subject& subject) {
  if (args.proxies.empty()) return render::EveryProxyOf(args.dir, subject);
  std::vector<std::shared_ptr<const render::Proxy>> proxies;
  for (const std::string& name : args.proxies)
    proxies.push_back(render::ProxyFromName(name, subject, args.dir));
  return proxies;
}

void AddSceneOptions(CLI::App& sub, SceneArgs& args) {
  sub.add_option("dir", args.dir, "The light field: a folder with a journal or a transforms.json")
      ->required();
  sub.add_option(
      "--subject", args.subject,
      "Centre and radius x,y,z,r of the subject, where the light field does not say or another is wanted");
  sub.add_option(
      "--up", args.up,
      "x,y,z: what is upwards, for named paths and the viewer, where the cameras do not tell it right");
  sub.add_option("--size-limit", args.size_limit_px,
                 "Longer side of the photographs in pixels as they are read; 0: as they are")
      ->check(NonNegative());
  sub.add_option("--memory-mb", args.memory_mb,
                 "Photographs held in main memory; others are read again when they are needed")
      ->check(Positive());
  sub.add_option(
         "--gpu-memory", args.gpu_memory_mb,
         "MB of photographs in graphics memory (what the driver says is free, or 2048); a picture that "
         "needs more is drawn in several passes")
      ->check(CLI::Range(1.0, 1e6));
  sub.add_option(
         "--viewpoint-mesh", args.viewpoint_mesh,
         "Viewpoints are triangulated on the sphere, or in the plane of azimuth and elevation as in the "
         "thesis, for comparison")
      ->check(CLI::IsMember({"sphere", "plane"}));
  sub.add_option("--renderer", args.renderer,
                 "gl (OpenGL without a window), reference (plain, slow) or auto (gl where it is to be had)")
      ->check(CLI::IsMember({"auto", "gl", "reference"}));
}

void AddFieldDetails(CLI::App& sub, FieldArgs& args) {
  sub.add_option("--level", args.level, "Levels of subdivision: 0, 1, 2, 3, limit");
  sub.add_option("--lumigraph-views", args.lumigraph_k,
                 "Lumigraph weights: of so many views (4; of views on a line 3)")
      ->check(CLI::Range(1, render::kMostLumigraphViews));
  sub.add_option("--lumigraph-resolution", args.lumigraph_resolution,
                 "Lumigraph weights: penalty in radians for a view twice as far away (0.1)")
      ->check(NonNegative());
  sub.add_option("--lumigraph-triangles", args.lumigraph_triangles,
                 "Lumigraph weights at vertices: triangles in the image (2000)")
      ->check(CLI::Range(100, 1000000));
}

render::FieldOptions FieldDetails(const FieldArgs& args) {
  return {.level = render::LevelFromName(args.level),
          .lumigraph_k = args.lumigraph_k,
          .lumigraph_resolution = args.lumigraph_resolution,
          .lumigraph_triangles = args.lumigraph_triangles};
}

}  // namespace ulf::commands
