// The options that all rendering commands share: the light field, how much of it is loaded, the renderer.
#pragma once

#include <CLI/CLI.hpp>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "render/fields/field_options.h"
#include "render/quality/light_fit.h"
#include "render/renderer/renderer.h"

namespace ulf::commands {

struct SceneArgs {
  std::string dir;           // of the light field
  std::string subject;       // "x,y,z,radius", world units; empty: the light field's
  std::string up;            // direction "x,y,z"; empty: that of the cameras
  int size_limit_px = 0;     // of the photographs' longer side; 0: none
  double memory_mb = 2048;   // of photographs in main memory
  double gpu_memory_mb = 0;  // 0: RenderOptions::gpu_memory_mb
  std::string renderer = "auto";
  std::vector<std::string> proxies = {};  // names of proxies to compare; empty: all
  std::string viewpoint_mesh = "sphere";  // where it is triangulated; or "plane", for comparison
  std::string light = "auto";             // or "fit", "as-recorded"
  render::PhotographForm form = render::PhotographForm::kAuto;
};

void AddSceneOptions(CLI::App& sub, SceneArgs& args);

// Parses "gl" (throws Error without OpenGL), "reference", or "auto": OpenGL, or without it the reference
// renderer with one warning.
render::RendererKind RendererFromName(const std::string& name);
// Throws Refusal for an invalid subject, UsageError for an invalid direction.
render::SceneOptions OptionsOf(const SceneArgs& args);
std::shared_ptr<const render::RenderScene> Load(const SceneArgs& args);
// Loads the scene again with the views' masks in place of their photographs; null if the scene has no masks.
std::shared_ptr<const render::RenderScene> LoadMasks(const SceneArgs& args, const render::RenderScene& scene);
// Returns the mesh over which light is fitted: the first mesh among `in_use`, else the light field's own, so
// that choosing a proxy by name or by evidence gives the same picture. Returns null if there is none (with a
// warning if its file cannot be read), or if light stays as recorded.
std::shared_ptr<const render::Proxy> MeshForLight(
    const SceneArgs& args, const render::RenderScene& scene,
    const std::vector<std::shared_ptr<const render::Proxy>>& in_use);
// Fits the light of the scene's views over a mesh as `args.light` asks, and logs it in a line. Returns none
// if light stays as recorded or `mesh` is none; throws UsageError for "fit" without a mesh.
std::optional<render::LightFit> LightOf(const SceneArgs& args, const render::RenderScene& scene,
                                        const std::shared_ptr<const render::Proxy>& mesh);
// Makes the proxies named in `args.proxies`, or all of the light field. plane:fitted is fitted for `field`.
std::vector<std::shared_ptr<const render::Proxy>> Proxies(const SceneArgs& args,
                                                          const render::RenderScene& scene,
                                                          const render::FieldOptions& field);

// The details of a blending field, as in render::FieldOptions.
struct FieldArgs {
  int level = 1;
  std::string rules = "ulf";  // of subdivision; or "loop"
  int lumigraph_k = render::FieldOptions{}.lumigraph_k;
  double lumigraph_resolution = render::FieldOptions{}.lumigraph_resolution;
  int lumigraph_triangles = render::FieldOptions{}.lumigraph_triangles;
  double soft_width = render::FieldOptions{}.soft_width;
};

void AddFieldDetails(CLI::App& sub, FieldArgs& args);
// Returns options of the default kind.
render::FieldOptions FieldDetails(const FieldArgs& args);

}  // namespace ulf::commands
