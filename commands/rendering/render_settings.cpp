#include "commands/rendering/render_settings.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>

#include "core/base/counted.h"
#include "core/geometry/digest.h"
#include "core/light_field/folder/light_field_io.h"
#include "render/proxy/planes_proxy.h"
#include "render/quality/choice.h"

namespace ulf::commands {
namespace {

// Returns the values on which the field's weights depend, for render.json.
std::string FieldSetting(const render::FieldOptions& field) {
  const std::string name = render::FieldName(field.kind);
  switch (field.kind) {
    case render::FieldKind::kSubdivision:
      return fmt::format("{}, level {}", name, std::to_string(field.level));
    case render::FieldKind::kLumigraph:
    case render::FieldKind::kLumigraphPerPixel:
      return fmt::format("{}, {}, resolution {}, {}", name, Counted(field.lumigraph_k, "view"),
                         field.lumigraph_resolution, Counted(field.lumigraph_triangles, "triangle"));
    case render::FieldKind::kSoft:
      return fmt::format("{}, width {}", name, field.soft_width);
    case render::FieldKind::kLinear:
    case render::FieldKind::kNearest:
      break;
  }
  return name;
}

// Photographs are identified by their size on disk, which changes when one is replaced. Their times do not
// count, so that copies of the light field on several machines can fill one folder.
void AddPhotographs(const std::string& dir, Digest& views) {
  const LightField light_field = ReadLightField(dir);
  const auto add = [&](const std::string& file) {
    std::error_code missing;
    views.Add(static_cast<double>(std::filesystem::file_size(light_field.root / file, missing)));
  };
  for (const View& view : light_field.views) {
    add(view.image_path);
    if (!view.master_path.empty()) add(view.master_path);
  }
}

std::string SizesOf(const render::CameraPath& path) {
  const auto same = [&](const CameraModel& camera) {
    return camera.width == path.cameras.front().width && camera.height == path.cameras.front().height;
  };
  if (!std::ranges::all_of(path.cameras, same)) return "several sizes";
  return fmt::format("{}x{}", path.cameras.front().width, path.cameras.front().height);
}

}  // namespace

std::map<std::string, std::string> SettingsKnownEarly(const RenderArgs& args,
                                                      const render::RenderScene& scene,
                                                      const render::CameraPath& path) {
  Digest views, poses;
  for (const render::SceneView& view : scene.views) {
    views.Add(view.id);
    views.Add(view.cam_from_world);
    views.Add(view.camera);
    views.Add(view.black);
    views.Add(view.scale);
  }
  AddPhotographs(args.dir, views);
  for (std::size_t i = 0; i < path.cam_from_world.size(); ++i) {
    poses.Add(path.cam_from_world[i]);
    poses.Add(path.cameras[i]);
  }
  const Subject& subject = scene.subject;
  return {{"views", fmt::format("{} ({})", scene.views.size(), ChecksumText(views.Value()))},
          {"subject", fmt::format("{},{},{},{}", subject.center_in_world.x(), subject.center_in_world.y(),
                                  subject.center_in_world.z(), subject.radius)},
          {"path", fmt::format("{}, {} of {} ({})", args.path, Counted(path.cam_from_world.size(), "picture"),
                               SizesOf(path), ChecksumText(poses.Value()))},
          {"viewpoint mesh", args.viewpoint_mesh},
          {"renderer", RendererFromName(args.renderer) == render::RendererKind::kGl ? "gl" : "reference"},
          {"background", args.background.empty() ? "none" : args.background},
          {"fill", args.no_fill ? "none" : "nearest views"},
          {"shows", args.show_field ? "blending field" : "light"},
          {"format", args.format.empty() ? "png" : args.format},
          {"exposure", fmt::format("{} stops", args.exposure_stops)},
          {"weights", args.weights ? "written" : "not written"}};
}

std::map<std::string, std::string> NamedChoices(const RenderArgs& args) {
  std::map<std::string, std::string> named;
  if (args.field != render::kAuto) named["field"] = args.field;
  for (const char* proxy : {"plane", render::kPlanesProxy, "points", "mesh", "soft"})
    if (args.proxy == proxy) named["proxy"] = proxy;
  return named;
}

void AddChoices(const render::Renderer& renderer, double zoom, const std::vector<render::Aperture>& apertures,
                std::map<std::string, std::string>& settings) {
  const render::RenderScene& scene = renderer.scene();
  Digest light, lenses;
  for (const render::SceneView& view : scene.views) {
    if (view.correction == render::LightCorrection{}) continue;
    light.Add(view.id);
    for (const float gain : view.correction.gain.val) light.Add(gain);
    light.Add(view.correction.falloff_r2);
    light.Add(view.correction.falloff_r4);
  }
  for (const render::Aperture& aperture : apertures) {
    lenses.Add(aperture.radius);
    for (const double value : aperture.focus_in_world) lenses.Add(value);
  }
  settings["light"] = ChecksumText(light.Value());
  settings["field"] = FieldSetting(renderer.field());
  settings["proxy"] = fmt::format("{} ({})", scene.proxy->Name(), ChecksumText(scene.proxy->Fingerprint()));
  settings["zoom"] = fmt::format("{}", zoom);
  settings["aperture"] = fmt::format("{} ({})", ApertureText(apertures), ChecksumText(lenses.Value()));
}

}  // namespace ulf::commands
