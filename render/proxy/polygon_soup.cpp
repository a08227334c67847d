#include "render/proxy/polygon_soup.h"

#include <Eigen/Geometry>

namespace ulf::render {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// Uses Newell's normal, which is right for concave polygons as well.
Vector3d NormalOf(const std::vector<Eigen::Vector3f>& vertices, const std::vector<std::uint32_t>& polygon) {
  const Vector3d origin = vertices[polygon.front()].cast<double>();
  Vector3d normal = Vector3d::Zero();
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vector3d a = vertices[polygon[i]].cast<double>() - origin;
    const Vector3d b = vertices[polygon[(i + 1) % polygon.size()]].cast<double>() - origin;
    normal += a.cross(b);
  }
  return normal;
}

double TwiceArea(const Vector2d& a, const Vector2d& b, const Vector2d& c) {
  return (b - a).x() * (c - a).y() - (b - a).y() * (c - a).x();
}

}  // namespace

std::vector<std::array<std::uint32_t, 3>> Triangulate(const std::vector<Eigen::Vector3f>& vertices,
                                                      std::vector<std::uint32_t> polygon) {
  std::vector<std::array<std::uint32_t, 3>> triangles;
  if (polygon.size() > 3) {
    const Vector3d normal = NormalOf(vertices, polygon);
    const Vector3d x = normal.unitOrthogonal(), y = normal.norm() > 0 ? normal.normalized().cross(x) : x;
    std::vector<Vector2d> flat;
    for (const std::uint32_t corner : polygon) {
      const Vector3d p = vertices[corner].cast<double>();
      flat.emplace_back(p.dot(x), p.dot(y));
    }
    std::size_t at = 0, tried = 0;
    while (polygon.size() > 3) {
      const std::size_t n = polygon.size(), before = (at + n - 1) % n, after = (at + 1) % n;
      const Vector2d a = flat[before], b = flat[at], c = flat[after];
      bool ear = TwiceArea(a, b, c) > 0;
      for (std::size_t i = 0; ear && i < n; ++i)
        if (i != before && i != at && i != after && flat[i] != a && flat[i] != b && flat[i] != c)
          ear = TwiceArea(a, b, flat[i]) < 0 || TwiceArea(b, c, flat[i]) < 0 || TwiceArea(c, a, flat[i]) < 0;
      // A polygon without any ear crosses itself and is cut anywhere.
      if (!ear && ++tried <= n) {
        at = after;
        continue;
      }
      triangles.push_back({polygon[before], polygon[at], polygon[after]});
      polygon.erase(polygon.begin() + static_cast<std::ptrdiff_t>(at));
      flat.erase(flat.begin() + static_cast<std::ptrdiff_t>(at));
      at %= polygon.size();
      tried = 0;
    }
  }
  if (polygon.size() == 3) triangles.push_back({polygon[0], polygon[1], polygon[2]});
  return triangles;
}

}  // namespace ulf::render
