#include "commands/options/aperture_options.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cstdio>

#include "commands/options/command_line.h"
#include "commands/options/option_values.h"
#include "core/base/error.h"
#include "core/light_field/folder/light_field_io.h"

namespace ulf::commands {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

Vector2d PixelOf(const std::string& text, const CameraModel& camera) {
  Vector2d pixel;
  int end = 0;
  const int read = std::sscanf(text.c_str(), "%lf,%lf%n", &pixel.x(), &pixel.y(), &end);
  if (read != 2 || static_cast<std::size_t>(end) != text.size() || !pixel.allFinite())
    throw UsageError("--focus-at {}: expected a pixel of the first picture, X,Y from its top left corner",
                     text);
  if (pixel.minCoeff() < 0 || pixel.x() > camera.width || pixel.y() > camera.height)
    throw UsageError("--focus-at {}: lies outside the pictures, which have {}x{} pixels", text, camera.width,
                     camera.height);
  return pixel;
}

}  // namespace

void AddApertureOptions(CLI::App& sub, ApertureArgs& args) {
  auto* radius =
      sub.add_option("--aperture", args.radius,
                     "Depth of field: radius of the virtual lens in the light field's units (none)")
          ->check(NonNegative());
  sub.add_option("--f-number", args.f_number,
                 "The same as an f-number; the light field's units must be metres")
      ->check(Positive())
      ->excludes(radius);
  sub.add_option("--sensor-width-mm", args.sensor_width_mm,
                 "Width of the sensor for --f-number (36: full frame)")
      ->check(Positive());
  auto* distance = sub.add_option("--focus", args.focus_distance,
                                  "Distance of the focal plane along the optical axis, in the light field's "
                                  "units (the subject's centre is in focus)")
                       ->check(Positive());
  sub.add_option("--focus-at", args.focus_at,
                 "Pixel X,Y of the path's first picture: the proxy's point there stays in focus")
      ->excludes(distance);
}

void CheckApertureOptions(const ApertureArgs& args, const std::filesystem::path& light_field) {
  if (!args.IsSet() && (args.focus_distance || !args.focus_at.empty()))
    throw UsageError("{}: without an aperture everything is in focus; give --aperture or --f-number as well",
                     args.focus_distance ? "--focus" : "--focus-at");
  if (!args.f_number) return;
  const std::string units = ReadLightField(light_field).units;
  if (units != "metres")
    throw UsageError(
        "--f-number: {} has {} units, in which the size of a lens is unknown; give --aperture (radius in "
        "these units), or poses in metres (ulf capture --poses with a marker)",
        light_field.string(), units);
}

std::vector<render::Aperture> AperturesAlong(const ApertureArgs& args, const render::CameraPath& path,
                                             const render::RenderScene& scene) {
  Vector3d focus = scene.subject.center_in_world;
  if (!args.focus_at.empty())
    focus = render::PointOnProxy(*scene.proxy, path.cameras.front(), path.cam_from_world.front(),
                                 PixelOf(args.focus_at, path.cameras.front()));
  std::vector<render::Aperture> apertures;
  for (std::size_t i = 0; i < path.cam_from_world.size(); ++i) {
    const CameraModel& camera = path.cameras[i];
    render::Aperture& aperture = apertures.emplace_back();
    aperture.radius = args.radius ? *args.radius
                                  : render::ApertureRadius(args.f_number.value(), camera.fx, camera.width,
                                                           args.sensor_width_mm);
    aperture.focus_in_world = args.focus_distance ? path.cam_from_world[i].Inverse() *
                                                        Vector3d(*args.focus_distance * Vector3d::UnitZ())
                                                  : focus;
  }
  return apertures;
}

void RequireRings(const render::FieldOptions& field, const render::ViewpointMesh& mesh) {
  if (render::UsesMesh(field.kind)) return;
  if (mesh.span != render::Span::kSurface)
    throw Error("an aperture needs viewpoints that span a surface ({}); record more around them",
                mesh.Description());
  throw UsageError(
      "--field {}: this field has no mesh of viewpoints; with an aperture, give subdivision or linear",
      render::FieldName(field.kind));
}

void WarnOfWidth(const std::vector<render::Aperture>& apertures, const render::RenderScene& scene) {
  const double apart = scene.mesh.mean_edge_rad * scene.mesh.median_distance;
  const std::vector<Eigen::Vector3d> centers = scene.Centers();
  Vector3d middle = Vector3d::Zero();
  for (const Eigen::Vector3d& center : centers) middle += center / static_cast<double>(centers.size());
  double reach = 0;
  for (const Eigen::Vector3d& center : centers) reach = std::max(reach, (center - middle).norm());
  const auto widest = std::ranges::max_element(apertures, {}, &render::Aperture::radius);
  if (widest == apertures.end()) return;
  if (widest->radius > reach)
    spdlog::warn(
        "an aperture of {:.3g} (radius) is wider than the viewpoints reach ({:.3g}): the lens is cut off "
        "there",
        widest->radius, reach);
  if (widest->radius > apart) return;
  spdlog::warn(
      "an aperture of {:.3g} (radius) is no wider than the viewpoints are apart ({:.3g}): pictures are "
      "hardly more blurred than without one; give a wider one, or record views closer together",
      widest->radius, apart);
}

std::string ApertureText(const std::vector<render::Aperture>& apertures) {
  if (apertures.empty()) return "none";
  const auto [least, most] = std::ranges::minmax_element(apertures, {}, &render::Aperture::radius);
  return least->radius == most->radius ? fmt::format("radius {}", least->radius)
                                       : fmt::format("radius {} to {}", least->radius, most->radius);
}

}  // namespace ulf::commands
