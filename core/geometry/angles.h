// Angles between vectors, and conversions between degrees, which people write, and the code's radians.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>

namespace ulf {

constexpr double Radians(double degrees) { return degrees * M_PI / 180; }
constexpr double Degrees(double radians) { return radians * 180 / M_PI; }

// Returns the angle between two vectors of any length, in radians, 0 to pi; 0 if a vector is zero. Unlike
// the arc cosine of the scalar product it is accurate near 0 and pi.
inline double AngleBetween(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

}  // namespace ulf
