// Defines the arguments of `ulf render`, and lists the values on which its pictures depend.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "commands/options/aperture_options.h"
#include "commands/options/scene_options.h"
#include "render/output/camera_path.h"
#include "render/renderer/renderer.h"

namespace ulf::commands {

// The values of the options, which `ulf render --help` describes; an empty one or 0 was not given.
struct RenderArgs : SceneArgs {
  std::string path = "orbit";
  std::string field = "auto";
  std::string proxy = "auto";
  FieldArgs field_details;
  std::string frames;
  int width = 0, height = 0;
  double focal_px = 0, fov_deg = 0;  // of the pictures; 0: the photographs' or the path's
  double zoom = 0;                   // 0: FillingZoom() for named paths
  double fps = 30;
  ApertureArgs aperture;
  std::string out;
  std::string format;
  std::string exr_compression = "zip";
  double exposure_stops = 0;
  bool weights = false;
  bool overwrite = false;
  std::string background;
  bool show_field = false;
  bool no_fill = false;
  bool explain = false;
  bool json = false;
};

// All values on which the pictures of a path depend, as texts by their names, are stored in render.json,
// because a folder may only hold pictures that agree in them.

// Returns those that are known before fields and geometry are compared. The path is not zoomed yet.
std::map<std::string, std::string> SettingsKnownEarly(const RenderArgs& args,
                                                      const render::RenderScene& scene,
                                                      const render::CameraPath& path);
// Returns how the values for the field and the proxy will begin, where the options name them.
std::map<std::string, std::string> NamedChoices(const RenderArgs& args);
// Adds what the renderer draws with, and what follows from it.
void AddChoices(const render::Renderer& renderer, double zoom, const std::vector<render::Aperture>& apertures,
                std::map<std::string, std::string>& settings);

}  // namespace ulf::commands
