#include "render/proxy/proxy_choice.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "core/base/counted.h"
#include "core/base/error.h"
#include "core/base/shell_word.h"
#include "core/light_field/folder/light_field_io.h"
#include "render/proxy/depth_map_files.h"
#include "render/proxy/mesh_file.h"
#include "render/proxy/mesh_resolution.h"
#include "render/proxy/mesh_world.h"
#include "render/proxy/plane_search.h"
#include "render/proxy/planes_proxy.h"
#include "render/proxy/points_proxy.h"

namespace ulf::render {
namespace {

// Returns the share of the subject's distance in "0.9"; none if the text is no such number.
std::optional<double> DistanceShareFromText(const std::string& text) {
  double share = 0;
  int end = 0;
  if (std::sscanf(text.c_str(), "%lf%n", &share, &end) != 1 || static_cast<std::size_t>(end) != text.size() ||
      !std::isfinite(share) || !(share > 0))
    return std::nullopt;
  return share;
}

PlaneProxy::InWorld PlaneFromText(const std::string& text) {
  PlaneProxy::InWorld plane;
  int end = 0;
  const int read = std::sscanf(text.c_str(), "%lf,%lf,%lf,%lf%n", &plane.normal.x(), &plane.normal.y(),
                               &plane.normal.z(), &plane.offset, &end);
  const double length = plane.normal.norm();
  if (read != 4 || static_cast<std::size_t>(end) != text.size() || !std::isfinite(length) ||
      !std::isfinite(plane.offset) || !(length > 0))
    throw Refusal(Parameter("proxy"), "plane:" + text,
                  "a plane is x,y,z,d, its normal (not zero) and normal . point",
                  "or a share of the subject's distance, such as 0.9; or fitted");
  plane.normal /= length;
  plane.offset /= length;
  return plane;
}

std::shared_ptr<const TriangleMesh> TrianglesFrom(const std::filesystem::path& file) {
  MeshReading reading = ReadMeshFile(file);
  spdlog::info("{}: {}", file.string(), Counted(reading.mesh.triangles.size(), "triangle"));
  if (const std::string dropped = reading.Dropped(); !dropped.empty())
    spdlog::warn("{}: {}", file.string(), dropped);
  return std::make_shared<TriangleMesh>(std::move(reading.mesh));
}

// Makes a mesh of another program coarser that has more triangles than pictures show.
std::shared_ptr<const TriangleMesh> ShownTriangles(std::shared_ptr<const TriangleMesh> mesh,
                                                   const std::string& name, const Subject& subject,
                                                   const std::filesystem::path& light_field) {
  if (mesh->triangles.size() <= kMostTrianglesShown) return mesh;
  auto coarser = std::make_shared<TriangleMesh>(Simplified(*mesh, subject, kMostTrianglesShown));
  spdlog::info("{}: made coarser, to {}, more than pictures show; '{}' takes the whole mesh in ({}, {})",
               name, Counted(coarser->triangles.size(), "triangle"), ProxyCommand(light_field),
               Parameter("from"), Parameter("triangles"));
  return coarser;
}

std::shared_ptr<const Proxy> SoftFrom(const std::filesystem::path& light_field, const Subject& subject,
                                      std::shared_ptr<const TriangleMesh> mesh) {
  if (!HasDepthMaps(light_field))
    throw Error("{}: there are no depth maps", (light_field / kDepthMapsFolder).string());
  DepthMapReading reading = ReadDepthMaps(light_field, ReadLightField(light_field), mesh);
  if (reading.maps.empty())
    throw Error("{}: all depth maps are of views that are gone or have other poses now",
                (light_field / kDepthMapsFolder).string());
  if (reading.stale > 0)
    spdlog::warn(
        "{}: {} of views that are gone or have other poses now {} not used; make them again with: ulf proxy "
        "{}",
        (light_field / kDepthMapsFolder).string(), Counted(reading.stale, "depth map"),
        reading.stale == 1 ? "is" : "are", ShellWord(light_field.string()));
  return std::make_shared<SoftProxy>(subject, std::move(mesh), std::move(reading.maps), reading.digest);
}

}  // namespace

std::vector<std::string> OwnProxies(const std::filesystem::path& light_field) {
  std::vector<std::string> names;
  // Points may be in one of several files, so the light field is read.
  const LightField read = ReadLightField(light_field);
  if (FindPlanes(read).why_none.empty()) names.push_back(kPlanesProxy);
  if (read.points.size() >= PointsProxy::kFewest) names.push_back("points");
  if (std::filesystem::exists(light_field / kMeshProxyFile)) {
    try {
      ReadMeshFile(light_field / kMeshProxyFile);
      names.push_back(HasDepthMaps(light_field) ? "soft" : "mesh");
    } catch (const Error& error) {
      spdlog::warn("{}; it is left out; '{}' makes it again", error.what(), ProxyCommand(light_field));
    }
  }
  return names;
}

std::vector<std::string> DefaultProxies(const std::filesystem::path& light_field) {
  std::vector<std::string> names = OwnProxies(light_field);
  std::ranges::reverse(names);
  names.push_back("plane");
  return names;
}

std::shared_ptr<const Proxy> ProxyFromName(const std::string& name, const Subject& subject,
                                           const std::filesystem::path& light_field) {
  constexpr char kPlane[] = "plane:";
  if (name == "plane") return std::make_shared<PlaneProxy>(subject);
  if (name == kFittedPlane)
    throw Refusal(Parameter("proxy"), name, "ulf render and ulf evaluate fit a plane and say where",
                  "give plane:SHARE here");
  if (const auto share =
          name.starts_with(kPlane) ? DistanceShareFromText(name.substr(sizeof kPlane - 1)) : std::nullopt)
    return std::make_shared<PlaneProxy>(subject, *share);
  if (name.starts_with(kPlane))
    return std::make_shared<PlaneProxy>(subject, PlaneFromText(name.substr(sizeof kPlane - 1)));
  if (name == kPlanesProxy) return MakePlanesProxy(subject, ReadLightField(light_field));
  if (name == "points") return std::make_shared<PointsProxy>(subject, ReadLightField(light_field).points);
  if (name == "mesh" || name == "soft") {
    const std::filesystem::path file = light_field / kMeshProxyFile;
    if (!std::filesystem::exists(file))
      throw Error("{}: there is no mesh of this light field yet; make it with: ulf proxy {}", file.string(),
                  ShellWord(light_field.string()));
    try {
      auto mesh = TrianglesFrom(file);
      if (name == "soft") return SoftFrom(light_field, subject, std::move(mesh));
      return std::make_shared<MeshProxy>(subject, std::move(mesh), name);
    } catch (const Error& error) {
      throw Error("{0}; make it again with 'ulf proxy {1}', or do without: {2} points, {2} plane",
                  error.what(), ShellWord(light_field.string()), Parameter("proxy"));
    }
  }
  const std::string ending = std::filesystem::path(name).extension().string();
  if (ending == ".ply" || ending == ".obj" || ending == ".PLY" || ending == ".OBJ") {
    const auto mesh = ShownTriangles(TrianglesFrom(name), name, subject, light_field);
    // Commands compare it with points that they measure where the light field has few.
    if (!light_field.empty())
      if (const LightField given = ReadLightField(light_field); given.points.size() >= kFewestPointsForMesh)
        RequireMeshOfWorld(name, *mesh, given);
    return std::make_shared<MeshProxy>(subject, mesh, std::filesystem::path(name).filename().string());
  }
  throw Refusal(Parameter("proxy"), name, "no such proxy",
                "there are plane, plane:x,y,z,d, planes, points, mesh, soft, and PLY or OBJ files");
}

std::shared_ptr<const Proxy> OwnProxy(const std::string& name, const Subject& subject,
                                      const std::filesystem::path& light_field) {
  if (name != "soft") return ProxyFromName(name, subject, light_field);
  try {
    return ProxyFromName(name, subject, light_field);
  } catch (const Error& error) {
    spdlog::warn("{}; the mesh alone is used", error.what());
    return ProxyFromName("mesh", subject, light_field);
  }
}

std::vector<std::shared_ptr<const Proxy>> EveryProxyOf(const std::filesystem::path& light_field,
                                                       const Subject& subject) {
  std::vector<std::shared_ptr<const Proxy>> proxies{ProxyFromName("plane", subject, light_field)};
  for (const std::string& name : OwnProxies(light_field))
    proxies.push_back(OwnProxy(name, subject, light_field));
  return proxies;
}

}  // namespace ulf::render
