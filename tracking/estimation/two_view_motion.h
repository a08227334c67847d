// Represents a motion between two views, computes its error on matched rays, and refines it, for
// relative_pose.h. Rays are unit vectors in their camera; errors, `gate` and `noise` are angles, radians;
// `used` holds indices of pairs. (Hartley and Zisserman, Multiple View Geometry, section 9.6.)
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "core/geometry/rigid3.h"

namespace ulf::tracking {

// The rays of one point in two views.
struct RayPair {
  Eigen::Vector3d first;
  Eigen::Vector3d second;
};

// Returns the matrix of the cross product: CrossMatrix(v) * w = v x w.
inline Eigen::Matrix3d CrossMatrix(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

Eigen::Matrix3d EssentialFromPose(const Rigid3& second_from_first);

// Returns how far a pair is from fulfilling second^T E first = 0 (first-order geometric error on the sphere).
double EpipolarError(const Eigen::Matrix3d& second_from_first_essential, const RayPair& pair);

// A rotation and a direction of translation.
struct Motion {
  Rigid3 second_from_first;  // translation of length 1
  Eigen::Matrix3d essential;
  // By RefineMotion(): sigma of the translation's direction, radians, for residuals of unit variance.
  double direction_sigma = 0;
  explicit Motion(const Rigid3& pose) : second_from_first(pose), essential(EssentialFromPose(pose)) {}
};

// Returns, of the four motions of an essential matrix, the one under which most pairs lie in front of both
// cameras; none if no pair ever does.
std::optional<Motion> BestMotion(const Eigen::Matrix3d& essential, std::span<const RayPair> pairs,
                                 const std::vector<int>& used);

// Returns the sum of squared errors, each at most gate².
double TruncatedCost(const Motion& motion, std::span<const RayPair> pairs, const std::vector<int>& used,
                     double gate);

// Returns the same sum over all pairs, in which a pair whose rays meet behind a camera costs gate² unless a
// parallax of `noise` explains that.
double CostInFront(const Motion& motion, std::span<const RayPair> pairs, double gate, double noise);

// Minimises TruncatedCost() over rotation and direction of translation by Levenberg-Marquardt. Under Huber's
// loss, outliers would pull towards motion along the optical axis.
Motion RefineMotion(const Motion& initial, std::span<const RayPair> pairs, const std::vector<int>& used,
                    double gate, int iterations = 6);

}  // namespace ulf::tracking
