// What is so near the subject's centre that it lies in no direction from there.
#pragma once

#include <Eigen/Core>
#include <algorithm>

#include "core/light_field/light_field.h"

namespace ulf::render {

inline bool IsAtCenter(const Subject& subject, const Eigen::Vector3d& point_in_world) {
  return !((point_in_world - subject.center_in_world).norm() > 1e-9 * std::max(1.0, subject.radius));
}

}  // namespace ulf::render
