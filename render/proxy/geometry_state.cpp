#include "render/proxy/geometry_state.h"

#include <fmt/format.h>

#include <charconv>
#include <utility>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/geometry/digest.h"
#include "core/light_field/points/ply_reader.h"
#include "render/proxy/depth_map_files.h"
#include "render/proxy/mesh_file.h"

namespace ulf::render {
namespace {

constexpr std::string_view kMadeBy = "made by: ", kOfViews = "views: ", kLeftOut = "views left out: ",
                           kOfPoses = "digest of views: ";

std::string DigestOfViews(const LightField& light_field) {
  Digest digest;
  for (const View& view : light_field.views) {
    digest.Add(static_cast<double>(view.id));
    digest.Add(view.cam_from_world);
    digest.Add(light_field.CameraOf(view));
  }
  return ChecksumText(digest.Value());
}

std::optional<MeshOrigin> OriginIn(const std::vector<std::string>& comments) {
  MeshOrigin origin;
  const auto value_of = [](const std::string& comment, std::string_view key) {
    return comment.starts_with(key) ? std::optional(comment.substr(key.size())) : std::nullopt;
  };
  for (const std::string& comment : comments) {
    if (const auto made_by = value_of(comment, kMadeBy)) origin.made_by = *made_by;
    if (const auto digest = value_of(comment, kOfPoses)) origin.digest = *digest;
    for (const auto& [key, number] : {std::pair{kOfViews, &origin.views}, {kLeftOut, &origin.left_out}})
      if (const auto text = value_of(comment, key))
        std::from_chars(text->data(), text->data() + text->size(), *number);
  }
  return origin.made_by.empty() || origin.digest.empty() ? std::nullopt : std::optional(origin);
}

}  // namespace

std::vector<std::string> OriginComments(const std::string& made_by, const LightField& light_field,
                                        std::size_t left_out) {
  std::vector<std::string> comments{fmt::format("{}{}", kMadeBy, made_by),
                                    fmt::format("{}{}", kOfViews, light_field.views.size()),
                                    fmt::format("{}{}", kOfPoses, DigestOfViews(light_field))};
  if (left_out > 0) comments.push_back(fmt::format("{}{}", kLeftOut, left_out));
  return comments;
}

std::optional<GeometryState> GeometryStateOf(const LightField& light_field) {
  const std::filesystem::path file = light_field.root / kMeshProxyFile;
  if (!std::filesystem::exists(file)) return std::nullopt;
  GeometryState state;
  try {
    const TriangleMesh mesh = ReadMeshFile(file).mesh;
    state.vertices = mesh.vertices.size();
    state.triangles = mesh.triangles.size();
    state.origin = OriginIn(ply::ParseHeader(ReadWholeFile(file), file.string()).comments);
    state.has_views_of_mesh = state.origin && state.origin->digest == DigestOfViews(light_field);
    if (state.origin) state.mesh_fits = state.has_views_of_mesh && state.origin->left_out == 0;
    if (!HasDepthMaps(light_field.root)) return state;
    const DepthMapReading reading = ReadDepthMaps(light_field.root, light_field, nullptr);
    state.maps = reading.maps.size();
    state.stale_maps = reading.stale;
  } catch (const Error& error) {
    state.problem = error.what();
  }
  return state;
}

}  // namespace ulf::render
