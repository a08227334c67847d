// Finds the few planes on which most tracked points lie, without knowing the vertical.
//
// The pictures decide whether a point lies on a plane: put onto the plane along the ray from a viewpoint that
// sees it, it must move by less than 5 mrad when seen from the neighbouring viewpoints. So the relief that
// counts as flat grows with the square of the distance and shrinks with the distance of viewpoints, no length
// is a parameter, and the scene in any unit gives the same planes.
//
// Planes are found one after the other, by samples of three points (Fischler and Bolles 1981), each among the
// points that are left. A sample's score is that of a matched filter: points on the plane count for it,
// points just off it count against it, and evenly spread points cancel out, so that a thin slab of a cloud of
// points is no plane.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "core/base/quantile.h"
#include "core/light_field/light_field.h"

namespace ulf::render {

struct FoundPlane {
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  // unit, world frame, towards most viewpoints
  double offset = 0;                                  // normal . x of its points x
  std::vector<std::size_t> points;                    // indices into LightField::points, ascending
};

struct PlaneSearch {
  std::vector<FoundPlane> planes;  // the most points first; empty if `why_none` is set
  std::size_t points = 0;          // number of examined points
  double explained = 0;            // share of them on a plane
  std::string why_none;            // a clause for people; empty: there are planes
};

// Examines the finite points of the light field; the views only tell from where points were seen.
PlaneSearch FindPlanes(const LightField& light_field);

// Returns for each point of the light field the viewpoints of the views that show it, the nearest first;
// without a track the nearest viewpoint of all. Empty for a point that is not finite, and without views.
std::vector<std::vector<Eigen::Vector3d>> ViewpointsOfPoints(const LightField& light_field);

// Returns the median distance from a point to its fourth nearest, which is a little more than the points'
// spacing, in a square grid its mesh width. Needs a point; of many, `most_asked` to twice as many count.
template <typename Point>
double SpacingOf(const std::vector<Point>& points, std::size_t most_asked = SIZE_MAX) {
  constexpr std::size_t kNeighbour = 4;
  std::vector<double> spacings, distances;
  const std::size_t step = std::max<std::size_t>(1, points.size() / most_asked);
  for (std::size_t i = 0; i < points.size(); i += step) {
    distances.clear();
    for (const Point& other : points) distances.push_back((other - points[i]).norm());  // its own is 0
    const auto at = distances.begin() + static_cast<long>(std::min(kNeighbour, distances.size() - 1));
    std::nth_element(distances.begin(), at, distances.end());
    spacings.push_back(*at);
  }
  return Median(std::move(spacings));
}

}  // namespace ulf::render
