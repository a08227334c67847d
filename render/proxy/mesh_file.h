// Reads and writes triangle meshes. It writes binary little-endian PLY with vertex normals, and reads PLY
// (ASCII, or binary of either byte order) and Wavefront OBJ of other programs; polygons are cut into
// triangles, and colours, normals and texture coordinates are ignored.
//
// CGAL's readers do not serve: they stop at a "nan" in a text file, and say only that reading failed.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "core/base/shell_word.h"
#include "render/proxy/triangle_mesh.h"

namespace ulf::render {

struct MeshReading {
  TriangleMesh mesh;
  // Counts of what the reader left out:
  std::size_t vertices_not_finite = 0;
  std::size_t faces_at_them = 0;       // faces with such a corner
  std::size_t faces_without_area = 0;  // fewer than three different corners

  // Returns "dropped 2 vertices that are not finite and 5 faces at them"; empty if nothing was left out.
  std::string Dropped() const;
};

// Throws Error that names file and fault: missing, not PLY or OBJ, truncated, an unknown vertex, no triangle.
MeshReading ReadMeshFile(const std::filesystem::path& file);

// Returns the bytes of a PLY file; `comments` are lines for its header.
std::string MeshPlyBytes(const TriangleMesh& mesh, const std::vector<std::string>& comments = {});
// Writes the whole file or nothing. Throws DiskFullError or Error.
void WriteMeshPly(const std::filesystem::path& file, const TriangleMesh& mesh,
                  const std::vector<std::string>& comments = {});

// The file of the mesh, and the folder of the depth maps beside it (depth_map_files.h).
inline constexpr char kMeshProxyFile[] = "proxy.ply";
inline constexpr char kDepthMapsFolder[] = "depth";

// Returns the command that makes mesh and maps, for messages: "ulf proxy vase".
inline std::string ProxyCommand(const std::filesystem::path& light_field) {
  return "ulf proxy " + ShellWord(light_field.string());
}

}  // namespace ulf::render
