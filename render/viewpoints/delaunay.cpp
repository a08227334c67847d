#include "render/viewpoints/delaunay.h"

#include <CGAL/Delaunay_triangulation_2.h>
#include <CGAL/Delaunay_triangulation_on_sphere_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Projection_on_sphere_traits_3.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>
#include <utility>

namespace ulf::render {

std::vector<Triangle> SphericalDelaunay(const std::vector<Eigen::Vector3d>& directions) {
  using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
  using Traits = CGAL::Projection_on_sphere_traits_3<Kernel>;
  using VertexBase =
      CGAL::Triangulation_vertex_base_with_info_2<int, Traits,
                                                  CGAL::Triangulation_on_sphere_vertex_base_2<Traits>>;
  using FaceBase = CGAL::Triangulation_on_sphere_face_base_2<Traits>;
  using Structure = CGAL::Triangulation_data_structure_2<VertexBase, FaceBase>;
  using Triangulation = CGAL::Delaunay_triangulation_on_sphere_2<Traits, Structure>;

  if (directions.size() < 4) return {};
  Triangulation triangulation(Traits(Kernel::Point_3(0, 0, 0), 1.0));
  const auto construct = triangulation.geom_traits().construct_point_on_sphere_2_object();
  for (std::size_t i = 0; i < directions.size(); ++i) {
    const Eigen::Vector3d& d = directions[i];
    const auto vertex = triangulation.insert(construct(Kernel::Point_3(d.x(), d.y(), d.z())));
    if (vertex != Triangulation::Vertex_handle()) vertex->info() = static_cast<int>(i);
  }
  if (triangulation.dimension() < 2) return {};  // its iterators are undefined then

  std::vector<Triangle> triangles;
  for (auto face = triangulation.all_faces_begin(); face != triangulation.all_faces_end(); ++face) {
    if (face->is_ghost()) continue;
    Triangle triangle{face->vertex(0)->info(), face->vertex(1)->info(), face->vertex(2)->info()};
    const auto at = [&](int k) -> const Eigen::Vector3d& {
      return directions[static_cast<std::size_t>(triangle[static_cast<std::size_t>(k)])];
    };
    if (at(0).dot(at(1).cross(at(2))) > kLeastDirectionVolume) triangles.push_back(triangle);
  }
  return triangles;
}

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
