// Represents a motion between two views, with its error on matched rays and its refinement, for
// relative_pose.h. Rays are unit vectors in their camera; errors are angles, radians. (Hartley and Zisserman,
// Multiple View Geometry, section 9.6, for the four motions of an essential matrix.)
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "core/geometry/rigid3.h"

namespace ulf::tracking {

struct RayPair {
  Eigen::Vector3d first;
  Eigen::Vector3d second;
};

// CrossMatrix(v) * w = v x w
inline Eigen::Matrix3d CrossMatrix(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

Eigen::Matrix3d EssentialFromPose(const Rigid3& second_from_first);

// Returns the distance of a pair from an essential matrix (first-order geometric error on the sphere).
double EpipolarError(const Eigen::Matrix3d& second_from_first_essential, const RayPair& pair);

// Rotation and the direction of translation.
struct Motion {
  Rigid3 second_from_first;
  Eigen::Matrix3d essential;
  double direction_sigma = 0;  // radians for residuals of unit variance; set by RefineMotion()
  explicit Motion(const Rigid3& pose) : second_from_first(pose), essential(EssentialFromPose(pose)) {}
};

// Returns the motion of an essential matrix under which most of `pairs` lie in front of both cameras.
std::optional<Motion> BestMotion(const Eigen::Matrix3d& essential, std::span<const RayPair> pairs,
                                 const std::vector<int>& used);

double TruncatedCost(const Motion& motion, std::span<const RayPair> pairs, const std::vector<int>& used,
                     double gate);

// Returns the truncated cost, in which a pair whose rays meet behind a camera by more than `noise` of
// parallax explains counts as an outlier.
double CostInFront(const Motion& motion, std::span<const RayPair> pairs, double gate, double noise);

// Minimises the truncated epipolar error over rotation and direction of translation by Levenberg-Marquardt.
// Under Huber's loss, outliers would pull towards motion along the optical axis.
Motion RefineMotion(const Motion& initial, std::span<const RayPair> pairs, const std::vector<int>& used,
                    double gate, int iterations = 6);

}  // namespace ulf::tracking
