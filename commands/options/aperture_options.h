// The options of a virtual lens with a wide aperture (depth of field): its width, and its focus.
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
  std::optional<double> f_number;  // instead of the radius, for a sensor of `sensor_width_mm`
  double sensor_width_mm = 36;
  std::optional<double> focus_distance;  // of the focal plane along the optical axis, world units
  std::string focus_at;  // instead: "X,Y", a pixel of the first picture. Neither: the subject's centre
  bool IsSet() const { return radius || f_number; }
};

void AddApertureOptions(CLI::App& sub, ApertureArgs& args);

// Throws UsageError for a focus without an aperture, and for an f-number if world units are not metres.
void CheckApertureOptions(const ApertureArgs& args, const std::filesystem::path& light_field);

// Returns an aperture for each pose of the path; `args.IsSet()` must hold. Throws UsageError for a `focus_at`
// that is no pixel of the first picture.
std::vector<render::Aperture> AperturesAlong(const ApertureArgs& args, const render::CameraPath& path,
                                             const render::RenderScene& scene);

// A wide aperture blends rings of triangles of the viewpoint mesh (aperture_field.h). Throws Error if the
// viewpoints span no surface, UsageError if the blending field does not use the mesh.
void RequireRings(const render::FieldOptions& field, const render::ViewpointMesh& mesh);

// Warns if the widest aperture is no wider than neighbouring viewpoints are apart, and so has hardly an
// effect, or wider than the viewpoints reach.
void WarnOfWidth(const std::vector<render::Aperture>& apertures, const render::RenderScene& scene);

// Returns "none", "radius 0.1" or "radius 0.1 to 0.2" (world units), for users and for render.json.
std::string ApertureText(const std::vector<render::Aperture>& apertures);

}  // namespace ulf::commands
