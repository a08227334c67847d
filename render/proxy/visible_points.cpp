#include "render/proxy/visible_points.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Extreme_points_traits_adapter_3.h>
#include <CGAL/convex_hull_3.h>
#include <CGAL/property_map.h>

#include <algorithm>
#include <numeric>

#include "core/base/quantile.h"

namespace ulf::render {

using Eigen::Vector3d;

std::vector<std::size_t> VisiblePoints(const std::vector<Vector3d>& in_cam, double view_sr) {
  using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
  std::vector<std::size_t> indices(in_cam.size());
  std::iota(indices.begin(), indices.end(), std::size_t{0});
  if (in_cam.size() < 4) return indices;  // no hull
  std::vector<double> distances;
  for (const Vector3d& point : in_cam) distances.push_back(point.norm());
  // Flipped points lie on a sphere of radius 2 R. Between it and the chord of two neighbours at an angle t
  // there is 2 R (1 - cos t) = R t^2.
  const double between_points_sr = view_sr / static_cast<double>(in_cam.size());
  constexpr double kBeyondAll = 1.01;  // the sphere contains all points
  const double radius = std::max(kHiddenBehind * Median(distances) / between_points_sr,
                                 kBeyondAll * *std::ranges::max_element(distances));
  std::vector<Kernel::Point_3> flipped;
  for (std::size_t i = 0; i < in_cam.size(); ++i) {
    const Vector3d at = in_cam[i] * (2 * radius / distances[i] - 1);
    flipped.emplace_back(at.x(), at.y(), at.z());
  }
  flipped.emplace_back(0, 0, 0);
  indices.push_back(in_cam.size());
  std::vector<std::size_t> visible;
  const auto point_of = CGAL::make_property_map(flipped);
  CGAL::extreme_points_3(indices, std::back_inserter(visible),
                         CGAL::make_extreme_points_traits_adapter(point_of));
  std::erase(visible, in_cam.size());
  std::ranges::sort(visible);
  return visible;
}

}  // namespace ulf::render
