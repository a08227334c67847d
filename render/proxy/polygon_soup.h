// The unchecked contents of a mesh file: positions and polygons of any size.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace ulf::render {

struct PolygonSoup {
  std::vector<Eigen::Vector3f> vertices;
  std::vector<std::uint32_t> corners;  // of all polygons, concatenated
  std::vector<std::uint32_t> sizes;    // number of corners of each polygon
};

// Both parse the bytes of a file. All corners they return are below vertices.size(). They throw Error, which
// begins with `name`, for malformed bytes.
PolygonSoup PolygonsFromPly(const std::string& bytes, const std::string& name);
PolygonSoup PolygonsFromObj(const std::string& bytes, const std::string& name);

// Triangulates a polygon by ear clipping, and keeps its orientation; returns indices into `vertices`. The
// result is right for any simple polygon that is nearly planar.
std::vector<std::array<std::uint32_t, 3>> Triangulate(const std::vector<Eigen::Vector3f>& vertices,
                                                      std::vector<std::uint32_t> polygon);

}  // namespace ulf::render
