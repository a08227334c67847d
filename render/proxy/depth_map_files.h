// A light field's geometry on disk: its mesh (DIR/proxy.ply) and the depth maps of its views: DIR/depth/, a
// 16-bit PNG for each (1 / depth along the optical axis, in units of its own) and maps.json, which says
// whose they are, by which camera, in which unit, how uncertain, and which pose the view had.
// docs/light_field.md describes it.
//
// Mesh and maps change together: while they do, maps.json lists the maps of both meshes, each with its mesh's
// checksum. The renaming of the new mesh is the one moment of change, so that a kill leaves the geometry of
// before or the new one.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "core/light_field/light_field.h"
#include "render/proxy/soft_proxy.h"
#include "render/proxy/view_depth_map.h"

namespace ulf::render {

// What becomes of the geometry that is there.
enum class FormerGeometry { kReplaced, kKept };

struct KeptGeometry {
  std::optional<std::filesystem::path> mesh, maps;  // where they are now, under kept/
};

// Writes the mesh (MeshPlyBytes) and the maps that were made beside it (by View::id; empty: none) in place of
// the geometry that is there, and no other file. Throws DiskFullError, Error: then nothing that it wrote is
// left, and what was there stays.
KeptGeometry WriteGeometryFiles(const LightField& light_field, const std::string& mesh_ply,
                                const std::map<int, ViewDepthMap>& maps, FormerGeometry former);

// Does what a killed WriteGeometryFiles() left undone: removes the maps that do not count, or moves
// them to kept/.
void FinishGeometryFiles(const std::filesystem::path& light_field_folder);

// Takes out the maps of views that `light_field` does not have, and those that are not bound to the pose that
// the view has there: `made_under` has another, by more than a tenth of a pixel at the subject. Returns how
// many of the latter. (Maps whose views all moved as one would be right nevertheless; nothing here tells.)
std::size_t TakeOutMovedMaps(const LightField& light_field, const std::map<int, Rigid3>& made_under,
                             std::map<int, ViewDepthMap>& maps);

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

// Files whose checksums an index beside them keeps.
// As an index keeps it.
std::string ChecksumForIndex(std::string_view bytes);
// Throws Error where the file is missing, or its bytes have another checksum.
std::string ReadIndexedFile(const std::filesystem::path& path, const std::string& checksum);

}  // namespace ulf::render
