// Meshes on disk. Written: binary little-endian PLY with vertex normals. Read: PLY (ASCII, binary of either
// byte order) and Wavefront OBJ from whatever made them; polygons are cut into triangles, colours, normals
// and texture coordinates are not read.
//
// CGAL's readers were tried: they stop at a "nan" in a text file, and say no more than that reading failed.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

#include "render/proxy/triangle_mesh.h"

namespace ulf::render {

struct MeshReading {
  TriangleMesh mesh;
  // What was left out.
  std::size_t vertices_not_finite = 0;
  std::size_t faces_at_them = 0;       // faces with such a corner
  std::size_t faces_without_area = 0;  // fewer than three different corners

  // "dropped 2 vertices that are not finite and 5 faces at them"; empty when nothing was.
  std::string Dropped() const;
};

// Throws Error naming the file and what is wrong: missing, neither PLY nor OBJ, truncated, a corner that is
// no vertex, nothing to show in it.
MeshReading ReadMeshFile(const std::filesystem::path& file);

std::string MeshPlyBytes(const TriangleMesh& mesh);
// Whole or not at all.
void WriteMeshPly(const std::filesystem::path& file, const TriangleMesh& mesh);

}  // namespace ulf::render
