#include "render/viewpoints/planar_delaunay.h"

#include <CGAL/Delaunay_triangulation_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>

#include <utility>

namespace ulf::render {

std::vector<Triangle> PlanarDelaunay(const std::vector<Eigen::Vector2d>& points) {
  using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
  using VertexBase = CGAL::Triangulation_vertex_base_with_info_2<int, Kernel>;
  using Triangulation =
      CGAL::Delaunay_triangulation_2<Kernel, CGAL::Triangulation_data_structure_2<VertexBase>>;
  std::vector<std::pair<Kernel::Point_2, int>> numbered;
  for (std::size_t i = 0; i < points.size(); ++i)
    numbered.emplace_back(Kernel::Point_2(points[i].x(), points[i].y()), static_cast<int>(i));
  const Triangulation triangulation(numbered.begin(), numbered.end());
  std::vector<Triangle> triangles;
  for (auto face = triangulation.finite_faces_begin(); face != triangulation.finite_faces_end(); ++face)
    triangles.push_back({face->vertex(0)->info(), face->vertex(1)->info(), face->vertex(2)->info()});
  return triangles;
}

}  // namespace ulf::render
