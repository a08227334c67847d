// The options of a wide aperture: its width, and its focus.
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "render/fields/field_options.h"
#include "render/output/camera_path.h"

namespace ulf::commands {

struct ApertureArgs {
  std::optional<double> radius;    // world units
  std::optional<double> f_number;  // in place of the radius, for a sensor of `sensor_width_mm`
  double sensor_width_mm = 36;
  std::optional<double> focus_distance;  // along the optical axis
  std::string focus_at;                  // in its place: pixel X,Y of the first picture
  bool IsSet() const { return radius || f_number; }
};

void AddApertureOptions(CLI::App& sub, ApertureArgs& args);

// Throws UsageError for options that need another option, and for an f-number if the units are not metres.
void CheckApertureOptions(const ApertureArgs& args, const std::filesystem::path& light_field);

// Returns an aperture for each pose of a path with cameras. Throws UsageError for a pixel outside the
// picture.
std::vector<render::Aperture> AperturesAlong(const ApertureArgs& args, const render::CameraPath& path,
                                             const render::RenderScene& scene);

// Throws an error with the remedy if the blending field in use has no rings.
void RequireRings(const render::FieldOptions& field, const render::ViewpointMesh& mesh);

// Warns if the widest aperture has no effect, or is wider than the viewpoints reach.
void WarnOfWidth(const std::vector<render::Aperture>& apertures, const render::RenderScene& scene);

// Returns a text for users and for render.json.
std::string ApertureText(const std::vector<render::Aperture>& apertures);

}  // namespace ulf::commands
