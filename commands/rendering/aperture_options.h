// A wide aperture on the command line: how wide, and where it is focused.
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "render/output/camera_path.h"

namespace ulf::commands {

struct ApertureArgs {
  std::optional<double> radius;    // world units
  std::optional<double> f_number;  // instead, of a full-frame lens or what `sensor_width_mm` says
  double sensor_width_mm = 36;
  std::optional<double> focus_distance;  // along the optical axis
  std::string focus_at;                  // or pixel X,Y of the first picture
  bool Asked() const { return radius || f_number; }
};

void AddApertureOptions(CLI::App& sub, ApertureArgs& args);

// UsageError for options that need another, and where an f-number has no metres to be one of.
void CheckApertureOptions(const ApertureArgs& args, const std::filesystem::path& light_field);

// One for each pose of a path that has a camera for each pose. UsageError for a pixel outside the picture.
std::vector<render::Aperture> AperturesAlong(const ApertureArgs& args, const render::CameraPath& path,
                                             const render::RenderScene& scene);

// Throws what to do where the blending field in use has no rings to widen.
void RequireRings(const render::FieldOptions& field, const render::ViewpointMesh& mesh);

// Says it where none of them is wide enough to make a difference.
void WarnOfWidth(const std::vector<render::Aperture>& apertures, const render::RenderScene& scene);

// For people and for render.json.
std::string ApertureText(const std::vector<render::Aperture>& apertures);

}  // namespace ulf::commands
