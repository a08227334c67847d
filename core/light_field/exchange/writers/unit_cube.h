// Determines the region of a light field that a radiance field resolves best, and the extent of its content.
#pragma once

#include <Eigen/Core>

#include "core/light_field/light_field.h"

namespace ulf {

// Returns the light field's subject, or else the point where its optical axes meet. Throws Refusal, which
// names the form and the remedy, if there is none.
Subject SubjectForExport(const LightField& light_field, const char* form);

// instant-ngp's world: nerf_scale * p + offset lies in the cube from 0 to 1 for the region of best
// resolution, and in a cube of `aabb_scale` times that size around its middle for all that is rendered.
struct UnitCube {
  double scale = 1;
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();
  int aabb_scale = 1;  // a power of two, 1 to 128
};

// The subject's sphere fills the middle of the unit cube. Without a subject (a place that was walked through)
// the median of the points, by each coordinate, is the middle. The larger cube holds nineteen of twenty
// points and all cameras; if every view has a mask that isolates the subject (a turntable's), it is the unit
// cube. Throws Refusal if there is neither a subject nor points.
UnitCube UnitCubeOf(const LightField& light_field);

}  // namespace ulf
