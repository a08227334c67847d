// Determines the region of a light field that a radiance field (instant-ngp's, NeRF's) should resolve best,
// and the extent of all content.
#pragma once

#include <Eigen/Core>

#include "core/light_field/light_field.h"

namespace ulf {

// Returns the light field's subject, or else SubjectFromAxes(). Throws a Refusal that names `form` (the name
// of a form of export) and the remedy if there is neither.
Subject SubjectForExport(const LightField& light_field, const char* form);

// instant-ngp's world: for a point p of the light field's world, scale * p + offset lies in the cube from
// 0 to 1 if p is in the region of best resolution, and in a concentric cube `aabb_scale` times as large if
// p is rendered.
struct UnitCube {
  double scale = 1;
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();
  int aabb_scale = 1;  // a power of two, 1 to 128
};

// The subject's sphere fills the middle of the unit cube. Without a subject (a place that was walked through)
// the middle four fifths of the points, by each coordinate, take its place, or else SubjectForExport(). The
// larger cube holds nineteen of twenty points and all cameras; for a turntable, whose masks isolate the
// subject, it is the unit cube. Throws Refusal as SubjectForExport() does.
UnitCube UnitCubeOf(const LightField& light_field);

}  // namespace ulf
