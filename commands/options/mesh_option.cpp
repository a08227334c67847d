#include "commands/options/mesh_option.h"

#include <filesystem>

#include "core/base/lowercase.h"
#include "core/base/progress.h"
#include "core/light_field/folder/light_field_io.h"
#include "render/proxy/mesh_file.h"
#include "render/proxy/mesh_world.h"
#include "tracking/refine/refine_input.h"
#include "tracking/refine/triangulate.h"

namespace ulf::commands {
namespace {

void MeasureMissingPoints(LightField& light_field) {
  if (light_field.points.size() >= render::kFewestPointsForMesh) return;
  Progress progress("points, to compare the mesh with");
  tracking::TriangulationOptions options{.max_side_px = 800};
  options.progress = [&](double share, const std::string& stage) { progress.Show(share, stage); };
  light_field.points = tracking::WithViewIds(
      tracking::TriangulateViews(tracking::RefineInputOf(light_field), options).points, light_field);
}

}  // namespace

void RequireMeshOfLightField(const std::string& name, const render::TriangleMesh& mesh,
                             const std::string& dir) {
  LightField light_field = ReadLightField(dir);
  MeasureMissingPoints(light_field);
  render::RequireMeshOfWorld(name, mesh, light_field);
}

void RequireProxyOfLightField(const std::string& proxy, const std::string& dir) {
  const std::string ending = Lowercase(std::filesystem::path(proxy).extension().string());
  if (ending != ".ply" && ending != ".obj") return;
  if (ReadLightField(dir).points.size() >= render::kFewestPointsForMesh) return;
  RequireMeshOfLightField(proxy, render::ReadMeshFile(proxy).mesh, dir);
}

}  // namespace ulf::commands
