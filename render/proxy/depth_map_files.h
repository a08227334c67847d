// Stores a light field's geometry: its mesh (DIR/proxy.ply) and the depth maps of its views in DIR/depth/, a
// 16-bit PNG for each (1 / depth along the optical axis, in its own unit), with maps.json, which holds each
// map's view, camera, unit, uncertainty, and digests of its bytes and of the pose and camera under which it
// was made. docs/light_field.md describes it.
//
// Mesh and maps change together: meanwhile maps.json lists the maps of both meshes, each with its mesh's
// checksum. Renaming the new mesh switches atomically, so that a kill leaves the old geometry or the new one.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "core/light_field/light_field.h"
#include "render/proxy/soft_proxy.h"
#include "render/proxy/view_depth_map.h"

namespace ulf::render {

// Says whether existing geometry is replaced or moved to kept/.
enum class FormerGeometry { kReplaced, kKept };

struct KeptGeometry {
  std::optional<std::filesystem::path> mesh, maps;  // where they are now, under kept/; none: not kept
};

// Writes the mesh (MeshPlyBytes) and its maps (by View::id; empty: none) in place of the existing geometry.
// Throws DiskFullError or Error; then its own files are removed, and the existing ones stay.
KeptGeometry WriteGeometryFiles(const LightField& light_field, const std::string& mesh_ply,
                                const std::map<int, ViewDepthMap>& maps, FormerGeometry former);

// Finishes a killed WriteGeometryFiles(): removes maps that belong to another mesh, or moves them to kept/.
void FinishGeometryFiles(const std::filesystem::path& light_field_folder);

// Removes from `maps` those of views that `light_field` does not have, and those whose view has another pose
// there than in `made_under`, by more than a tenth of a pixel at the subject. Returns the number of the
// latter. (Maps whose views all moved as one would still be right; this is not detected.)
std::size_t TakeOutMovedMaps(const LightField& light_field, const std::map<int, Rigid3>& made_under,
                             std::map<int, ViewDepthMap>& maps);

bool HasDepthMaps(const std::filesystem::path& light_field_folder);  // whether there is a maps.json

struct DepthMapReading {
  SoftProxy::Maps maps;      // read lazily; an unreadable one is replaced by the mesh's, with a warning
  std::uint64_t digest = 0;  // of the maps' bytes
  std::size_t stale = 0;     // number of maps whose view was removed or has another pose or camera now
};
// `mesh` is that of kMeshProxyFile; null if no map will be read. Throws Error for an invalid maps.json, or
// one that belongs to another mesh.
DepthMapReading ReadDepthMaps(const std::filesystem::path& light_field_folder, const LightField& light_field,
                              std::shared_ptr<const TriangleMesh> mesh);

// Returns the checksum of a file's bytes for the index beside it (maps.json).
std::string ChecksumForIndex(std::string_view bytes);
// Reads a file of an index. Throws Error if it is missing, or its bytes have another checksum.
std::string ReadIndexedFile(const std::filesystem::path& path, const std::string& checksum);

}  // namespace ulf::render
