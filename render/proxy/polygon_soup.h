// What a mesh file says before anybody has judged it: positions and polygons of any size.
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
  std::vector<std::uint32_t> sizes;    // corners of each polygon
};

// Both throw Error that begins with `name`; indices are below vertices.size().
PolygonSoup PolygonsFromPly(const std::string& bytes, const std::string& name);
PolygonSoup PolygonsFromObj(const std::string& bytes, const std::string& name);

// Corner indices into `vertices`, three a triangle, by cutting ears: right for any simple polygon that is
// about plane; the way round is kept.
std::vector<std::array<std::uint32_t, 3>> Triangulate(const std::vector<Eigen::Vector3f>& vertices,
                                                      std::vector<std::uint32_t> polygon);

}  // namespace ulf::render
