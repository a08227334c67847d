#include "render/proxy/mesh_file.h"

#include <fmt/core.h>

#include <algorithm>
#include <limits>

#include "core/base/atomic_file.h"
#include "core/base/counted.h"
#include "core/base/error.h"
#include "core/base/lowercase.h"
#include "render/proxy/polygon_soup.h"

namespace ulf::render {
namespace {

PolygonSoup PolygonsOf(const std::filesystem::path& file) {
  const std::string ending = Lowercase(file.extension().string());
  const std::string bytes = ReadWholeFile(file);
  const std::string name = file.string();
  if (bytes.empty()) throw Error("{}: the file is empty; export the mesh again", name);
  if (bytes.starts_with("ply")) return PolygonsFromPly(bytes, name);
  if (ending == ".obj") return PolygonsFromObj(bytes, name);
  throw Error("{}: neither a PLY file nor an OBJ file; convert the mesh to one of them", name);
}

// Marks a dropped vertex.
constexpr std::uint32_t kDropped = std::numeric_limits<std::uint32_t>::max();

}  // namespace

std::string MeshReading::Dropped() const {
  std::string text;
  if (vertices_not_finite > 0)
    text = vertices_not_finite == 1 ? fmt::format("dropped 1 vertex that is not finite and {} at it",
                                                  Counted(faces_at_them, "face"))
                                    : fmt::format("dropped {} vertices that are not finite and {} at them",
                                                  vertices_not_finite, Counted(faces_at_them, "face"));
  if (faces_without_area > 0)
    text += fmt::format("{}{} with fewer than three different corners", text.empty() ? "dropped " : ", and ",
                        Counted(faces_without_area, "face"));
  return text;
}

MeshReading ReadMeshFile(const std::filesystem::path& file) {
  const PolygonSoup soup = PolygonsOf(file);
  MeshReading reading;
  std::vector<std::uint32_t> number(soup.vertices.size(), kDropped);
  for (std::size_t i = 0; i < soup.vertices.size(); ++i) {
    if (!soup.vertices[i].allFinite()) {
      ++reading.vertices_not_finite;
      continue;
    }
    number[i] = static_cast<std::uint32_t>(reading.mesh.vertices.size());
    reading.mesh.vertices.push_back(soup.vertices[i]);
  }
  std::size_t first = 0;
  std::vector<std::uint32_t> polygon;
  for (const std::uint32_t size : soup.sizes) {
    polygon.clear();
    for (std::size_t i = first; i < first + size; ++i) {
      const std::uint32_t corner = number[soup.corners[i]];
      if (polygon.empty() || polygon.back() != corner) polygon.push_back(corner);
    }
    first += size;
    while (polygon.size() > 1 && polygon.front() == polygon.back()) polygon.pop_back();
    if (std::ranges::count(polygon, kDropped) > 0) {
      ++reading.faces_at_them;
      continue;
    }
    if (polygon.size() < 3) {
      ++reading.faces_without_area;
      continue;
    }
    for (const auto& triangle : Triangulate(reading.mesh.vertices, polygon))
      reading.mesh.triangles.push_back(triangle);
  }
  if (reading.mesh.triangles.empty()) {
    const std::string dropped = reading.Dropped();
    throw Error("{}: no triangles in it ({}{}); a proxy needs a surface: export a mesh, not a point cloud",
                file.string(), Counted(soup.sizes.size(), "face"), dropped.empty() ? "" : "; " + dropped);
  }
  return reading;
}

std::string MeshPlyBytes(const TriangleMesh& mesh, const std::vector<std::string>& comments) {
  std::string bytes = "ply\nformat binary_little_endian 1.0\n";
  for (const std::string& comment : comments) bytes += "comment " + comment + "\n";
  bytes += fmt::format(
      "element vertex {}\nproperty float x\nproperty float y\n"
      "property float z\nproperty float nx\nproperty float ny\nproperty float nz\nelement face {}\n"
      "property list uchar uint vertex_indices\nend_header\n",
      mesh.vertices.size(), mesh.triangles.size());
  const std::vector<Eigen::Vector3f> normals = VertexNormals(mesh);
  bytes.reserve(bytes.size() + 24 * mesh.vertices.size() + 13 * mesh.triangles.size());
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    bytes.append(reinterpret_cast<const char*>(mesh.vertices[i].data()), 3 * sizeof(float));
    bytes.append(reinterpret_cast<const char*>(normals[i].data()), 3 * sizeof(float));
  }
  for (const auto& corners : mesh.triangles) {
    bytes += '\3';
    bytes.append(reinterpret_cast<const char*>(corners.data()), 3 * sizeof(std::uint32_t));
  }
  return bytes;
}

void WriteMeshPly(const std::filesystem::path& file, const TriangleMesh& mesh,
                  const std::vector<std::string>& comments) {
  WriteFileAtomically(file, MeshPlyBytes(mesh, comments));
}

}  // namespace ulf::render
