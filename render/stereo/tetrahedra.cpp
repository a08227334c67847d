#include "render/stereo/tetrahedra.h"

#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Delaunay_triangulation_cell_base_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_cell_base_with_info_3.h>
#include <CGAL/Triangulation_vertex_base_with_info_3.h>
#include <CGAL/spatial_sort.h>

#include <algorithm>

namespace ulf::render {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using VertexBase = CGAL::Triangulation_vertex_base_with_info_3<std::uint32_t, Kernel>;
using CellBase = CGAL::Triangulation_cell_base_with_info_3<std::uint32_t, Kernel,
                                                           CGAL::Delaunay_triangulation_cell_base_3<Kernel>>;
using Delaunay =
    CGAL::Delaunay_triangulation_3<Kernel, CGAL::Triangulation_data_structure_3<VertexBase, CellBase>>;

bool Tetrahedra::Outer(std::uint32_t cell) const {
  const auto& of = corners[cell];
  return std::ranges::find(of, kAtInfinity) != of.end();
}

Tetrahedra DelaunayTetrahedra(const std::vector<Eigen::Vector3d>& points,
                              std::vector<std::uint32_t>* number) {
  // Insertion is faster in an order in which each point is near the previous one.
  using Traits =
      CGAL::Spatial_sort_traits_adapter_3<Kernel, CGAL::Pointer_property_map<Kernel::Point_3>::type>;
  std::vector<Kernel::Point_3> places;
  std::vector<std::size_t> order;
  for (const Eigen::Vector3d& point : points) {
    order.push_back(places.size());
    places.emplace_back(point.x(), point.y(), point.z());
  }
  CGAL::spatial_sort(order.begin(), order.end(), Traits(CGAL::make_property_map(places)));

  Tetrahedra result;
  if (number) number->assign(points.size(), 0);
  Delaunay delaunay;
  Delaunay::Cell_handle near;
  for (const std::size_t index : order) {
    const std::size_t before = delaunay.number_of_vertices();
    const Delaunay::Vertex_handle vertex = delaunay.insert(places[index], near);
    if (delaunay.number_of_vertices() > before) {
      vertex->info() = static_cast<std::uint32_t>(result.points.size());
      result.points.push_back(points[index]);
    }
    if (number) (*number)[index] = vertex->info();
    near = vertex->cell();
  }
  if (delaunay.dimension() < 3) return result;

  std::uint32_t count = 0;
  for (const Delaunay::Cell_handle cell : delaunay.all_cell_handles()) cell->info() = count++;
  result.corners.resize(count);
  result.neighbours.resize(count);
  for (const Delaunay::Cell_handle cell : delaunay.all_cell_handles()) {
    const std::uint32_t at = cell->info();
    for (int k = 0; k < 4; ++k) {
      const bool infinite = delaunay.is_infinite(cell->vertex(k));
      result.corners[at][static_cast<std::size_t>(k)] =
          infinite ? Tetrahedra::kAtInfinity : cell->vertex(k)->info();
      result.neighbours[at][static_cast<std::size_t>(k)] = cell->neighbor(k)->info();
    }
  }
  return result;
}

}  // namespace ulf::render
