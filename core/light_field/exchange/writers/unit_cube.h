// The region of a light field that a radiance field resolves best, and how far its content reaches beyond.
#pragma once

#include <Eigen/Core>

#include "core/light_field/light_field.h"

namespace ulf {

// The light field's subject, else the point where its optical axes meet. Throws Refusal, which names the form
// and the way out, where there is none.
Subject SubjectForExport(const LightField& light_field, const char* form);

// instant-ngp's world: nerf_scale * p + offset lies in the cube from 0 to 1 for what is resolved best, and in
// the cube of `aabb_scale` unit cubes around its middle for all that is rendered at all.
struct UnitCube {
  double scale = 1;
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();
  int aabb_scale = 1;  // a power of two, 1 to 128
};

// The subject's sphere fills the middle of the unit cube. Without a subject (a place that was walked through)
// the middle of the points does, by each coordinate. The larger cube holds nineteen of twenty points and all
// cameras; where every view has a mask that cuts the subject out of nothing (a turntable's), it is the unit
// cube. Throws Refusal where there is neither a subject nor points.
UnitCube UnitCubeOf(const LightField& light_field);

}  // namespace ulf
