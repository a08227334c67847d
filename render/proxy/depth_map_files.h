// The depth maps of a light field's views on disk: DIR/depth/, a 16-bit PNG for each (1 / depth along the optical axis,
// in units of its own) and maps.json, which says whose they are, by which camera, in which unit, how uncertain, and
// which pose the view had. docs/disk_format.md describes it.
//
// maps.json is written last and names what counts, the mesh beside which the maps were made among it: a kill at any moment
// leaves the maps of before, the new ones, or maps that do not count because the mesh is another one already.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <opencv2/core.hpp>
#include <optional>
#include <string>

#include "core/light_field/light_field.h"
#include "render/proxy/soft_proxy.h"
#include "render/proxy/view_depth_map.h"

namespace ulf::render {

inline constexpr char kDepthMapsFolder[] = "depth";

// `maps`: by View::id, made beside the mesh in kMeshProxyFile as it is now. Replaces the maps that `light_field` has, and
// no other file. Throws DiskFullError, Error: then nothing that it wrote is left, and what was there stays.
void WriteDepthMaps(const std::filesystem::path& light_field_folder, const LightField& light_field,
                    const std::map<int, ViewDepthMap>& maps);

// Takes out the maps of views that `light_field` does not have, and those that are not bound to the pose that the view has
// there: `made_under` has another, by more than a tenth of a pixel at the subject. Returns how many of the latter. (Maps
// whose views all moved as one would be right nevertheless; nothing here tells.)
std::size_t TakeOutMovedMaps(const LightField& light_field, const std::map<int, Rigid3>& made_under,
                             std::map<int, ViewDepthMap>& maps);

// Moves maps.json and the maps that it names to kept/depth, or the next free name; other files stay. Returns that folder;
// none: there are no maps. Throws Error; then each file is in one of the two folders. A kill leaves the same.
std::optional<std::filesystem::path> MoveDepthMapsToKept(const std::filesystem::path& light_field_folder);

bool HasDepthMaps(const std::filesystem::path& light_field_folder);

struct DepthMapReading {
  SoftProxy::Maps
      maps;  // read when they are needed; of one that cannot be read then, the mesh's stands in (a warning)
  std::uint64_t digest = 0;  // of the maps' bytes
  std::size_t stale = 0;     // maps of views that are gone, or have another pose or camera now
};
// `mesh`: of kMeshProxyFile. Throws Error for a maps.json that is no such file, or belongs to another mesh.
DepthMapReading ReadDepthMaps(const std::filesystem::path& light_field_folder, const LightField& light_field,
                              std::shared_ptr<const TriangleMesh> mesh);

}  // namespace ulf::render
