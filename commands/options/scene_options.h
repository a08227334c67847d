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
  std::string dir;
  std::string subject;
  std::string up;
  int size_limit_px = 0;
  double memory_mb = 2048;
  double gpu_memory_mb = 0;  // 0: RenderOptions::gpu_memory_mb
  std::string renderer = "auto";
  std::vector<std::string> proxies = {};  // to compare; empty: all
  std::string viewpoint_mesh = "sphere";
  std::string light = "auto";
  render::PhotographForm form = render::PhotographForm::kAuto;
};

void AddSceneOptions(CLI::App& sub, SceneArgs& args);

// "gl" (throws Error without OpenGL), "reference", or "auto": OpenGL, or without it the reference renderer
// with one warning.
render::RendererKind RendererFromName(const std::string& name);
// Throws UsageError for a subject or direction that is none.
render::SceneOptions OptionsOf(const SceneArgs& args);
std::shared_ptr<const render::RenderScene> Load(const SceneArgs& args);
// The masks of the same views in place of their photographs; null where nothing of them is cut out.
std::shared_ptr<const render::RenderScene> LoadMasks(const SceneArgs& args, const render::RenderScene& scene);
// The mesh over which light is evened, whatever is drawn over: one of those in use, else the light field's
// own. A choice by name then gives the picture of the same choice by evidence. Null where there is none, or
// light stays as recorded.
std::shared_ptr<const render::Proxy> MeshForLight(
    const SceneArgs& args, const render::RenderScene& scene,
    const std::vector<std::shared_ptr<const render::Proxy>>& in_use);
// What --light asks for: the light of the scene's views, fitted over a mesh, said in a line. None where light
// stays as recorded.
std::optional<render::LightFit> LightOf(const SceneArgs& args, const render::RenderScene& scene,
                                        const std::shared_ptr<const render::Proxy>& mesh);
// `field`: for which --proxy plane:fitted fits it.
std::vector<std::shared_ptr<const render::Proxy>> Proxies(const SceneArgs& args,
                                                          const render::RenderScene& scene,
                                                          const render::FieldOptions& field);

// The details of a blending field.
struct FieldArgs {
  int level = 1;
  std::string rules = "ulf";
  int lumigraph_k = render::FieldOptions{}.lumigraph_k;
  double lumigraph_resolution = render::FieldOptions{}.lumigraph_resolution;
  int lumigraph_triangles = render::FieldOptions{}.lumigraph_triangles;
  double soft_width = render::FieldOptions{}.soft_width;
};

void AddFieldDetails(CLI::App& sub, FieldArgs& args);
// Options of the default kind.
render::FieldOptions FieldDetails(const FieldArgs& args);

}  // namespace ulf::commands
