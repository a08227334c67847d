// Whether a point is so near the subject's centre that it has no direction from there.
#pragma once

#include <Eigen/Core>
#include <algorithm>

#include "core/light_field/light_field.h"

namespace ulf::render {

inline bool IsAtCenter(const Subject& subject, const Eigen::Vector3d& point_in_world) {
  // Of the subject's radius, or of one unit where that is larger: rounding.
  constexpr double kLeastShare = 1e-9;
  return !((point_in_world - subject.center_in_world).norm() > kLeastShare * std::max(1.0, subject.radius));
}

}  // namespace ulf::render
