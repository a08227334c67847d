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

// Parses "gl" (throws Error without OpenGL), "reference", or "auto": OpenGL, or without it the reference
// renderer with one warning.
render::RendererKind RendererFromName(const std::string& name);
// Throws UsageError for an invalid subject or direction.
render::SceneOptions OptionsOf(const SceneArgs& args);
std::shared_ptr<const render::RenderScene> Load(const SceneArgs& args);
// Loads the masks of the same views as photographs; returns null if nothing is cut out.
std::shared_ptr<const render::RenderScene> LoadMasks(const SceneArgs& args, const render::RenderScene& scene);
// Returns the mesh for the light fit, independently of the drawn proxy: one of those in use, or else the
// light field's own. A choice by name then gives the picture of the same choice by evidence. Null if there is
// none, or light stays as recorded.
std::shared_ptr<const render::Proxy> MeshForLight(
    const SceneArgs& args, const render::RenderScene& scene,
    const std::vector<std::shared_ptr<const render::Proxy>>& in_use);
// Fits the light of the scene's views over a mesh as --light asks, and logs it in a line. Returns none if
// light stays as recorded.
std::optional<render::LightFit> LightOf(const SceneArgs& args, const render::RenderScene& scene,
                                        const std::shared_ptr<const render::Proxy>& mesh);
// `field` is the one for which --proxy plane:fitted fits the plane.
std::vector<std::shared_ptr<const render::Proxy>> Proxies(const SceneArgs& args,
                                                          const render::RenderScene& scene,
                                                          const render::FieldOptions& field);

// The details of a blending field:
struct FieldArgs {
  int level = 1;
  std::string rules = "ulf";
  int lumigraph_k = render::FieldOptions{}.lumigraph_k;
  double lumigraph_resolution = render::FieldOptions{}.lumigraph_resolution;
  int lumigraph_triangles = render::FieldOptions{}.lumigraph_triangles;
  double soft_width = render::FieldOptions{}.soft_width;
};

void AddFieldDetails(CLI::App& sub, FieldArgs& args);
// Returns options of the default kind.
render::FieldOptions FieldDetails(const FieldArgs& args);

}  // namespace ulf::commands
