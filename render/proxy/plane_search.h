// The few planes on which most tracked points lie, found without knowing what is upright.
//
// Whether a point lies on a plane is asked of the pictures: put onto the plane along the ray from a viewpoint
// that sees it, it must move by less than `parallax_rad` when seen from the viewpoints beside. So the relief
// that counts as flat grows with the square of the distance and shrinks with how far viewpoints are apart, no
// length is a parameter, and the scene in any unit gives the same planes.
//
// Planes are found one after the other, by samples of three points (Fischler and Bolles 1981), each on what
// the ones before left over. A sample's score is that of a matched filter: points on the plane speak for it,
// points just off it against it, evenly distributed ones not at all; so that a slab through a cloud is no
// plane, as long as it is thin beside the cloud.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/light_field/light_field.h"

namespace ulf::render {

struct FoundPlane {
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  // unit, towards most viewpoints
  double offset = 0;                                  // normal . x of its points
  std::vector<std::size_t> points;                    // indices, ascending
};

struct PlaneSearch {
  std::vector<FoundPlane> planes;  // the most points first; empty where `why_none` says something
  std::size_t points = 0;          // that were looked at
  double explained = 0;            // share of them that lie on a plane
  std::string why_none;            // a clause
};

// Of the light field's points those that are finite are looked at; views only say where they were seen from.
PlaneSearch FindPlanes(const LightField& light_field);

// For each point of the light field the viewpoints of the views that show it, the nearest first; where that
// is not known, the nearest of all. Empty for a point that is not finite, and without views.
std::vector<std::vector<Eigen::Vector3d>> SeenFrom(const LightField& light_field);

}  // namespace ulf::render
