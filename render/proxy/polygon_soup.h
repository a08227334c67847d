// The contents of a mesh file before they are checked: positions and polygons of any size.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace ulf::render {

struct PolygonSoup {
  std::vector<Eigen::Vector3f> vertices;
  std::vector<std::uint32_t> corners;  // of all polygons, one after another
  std::vector<std::uint32_t> sizes;    // number of corners of each polygon
};

// Both return indices below vertices.size(), and throw Error whose text begins with `name`.
PolygonSoup PolygonsFromPly(const std::string& bytes, const std::string& name);
PolygonSoup PolygonsFromObj(const std::string& bytes, const std::string& name);

// Cuts a polygon into triangles by clipping ears; returns indices into `vertices`. Right for any simple
// polygon that is nearly plane; the orientation is kept.
std::vector<std::array<std::uint32_t, 3>> Triangulate(const std::vector<Eigen::Vector3f>& vertices,
                                                      std::vector<std::uint32_t> polygon);

}  // namespace ulf::render
