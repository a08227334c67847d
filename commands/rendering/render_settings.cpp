#include "commands/rendering/render_settings.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>

#include "core/base/counted.h"
#include "core/geometry/digest.h"
#include "core/light_field/folder/light_field_io.h"

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

std::map<std::string, std::string> SettingsOf(const RenderArgs& args, const render::Renderer& renderer,
                                              const render::CameraPath& path) {
  const render::RenderScene& scene = renderer.scene();
  Digest views, poses, lenses;
  const auto text = [](std::uint64_t value) { return fmt::format("{:016x}", value); };
  for (const render::SceneView& view : scene.views) {
    views.Add(view.id);
    views.Add(view.cam_from_world);
    views.Add(view.camera);
    views.Add(view.black);
    views.Add(view.scale);
    if (view.correction != render::LightCorrection{}) {
      for (const float gain : view.correction.gain.val) views.Add(gain);
      views.Add(view.correction.falloff_r2);
      views.Add(view.correction.falloff_r4);
    }
  }
  AddPhotographs(args.dir, views);
  for (std::size_t i = 0; i < path.cam_from_world.size(); ++i) {
    poses.Add(path.cam_from_world[i]);
    poses.Add(path.cameras[i]);
  }
  for (const render::Aperture& aperture : path.apertures) {
    lenses.Add(aperture.radius);
    for (const double value : aperture.focus_in_world) lenses.Add(value);
  }
  const Subject& subject = scene.subject;
  return {{"views", fmt::format("{} ({})", scene.views.size(), text(views.Value()))},
          {"subject", fmt::format("{},{},{},{}", subject.center_in_world.x(), subject.center_in_world.y(),
                                  subject.center_in_world.z(), subject.radius)},
          {"path", fmt::format("{}, {} of {} ({})", args.path, Counted(path.cam_from_world.size(), "picture"),
                               SizesOf(path), text(poses.Value()))},
          {"viewpoint mesh", args.viewpoint_mesh},
          {"field", FieldSetting(renderer.field())},
          {"proxy", fmt::format("{} ({})", scene.proxy->Name(), text(scene.proxy->Fingerprint()))},
          {"aperture", fmt::format("{} ({})", ApertureText(path.apertures), text(lenses.Value()))},
          {"renderer", RendererFromName(args.renderer) == render::RendererKind::kGl ? "gl" : "reference"},
          {"background", args.background.empty() ? "none" : args.background},
          {"fill", args.no_fill ? "none" : "nearest views"},
          {"shows", args.show_field ? "blending field" : "light"},
          {"format", args.format.empty() ? "png" : args.format},
          {"exposure", fmt::format("{} stops", args.exposure_stops)},
          {"weights", args.weights ? "written" : "not written"}};
}

}  // namespace ulf::commands
