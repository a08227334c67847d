// A motion between two views as matched rays see it, and its refinement on the epipolar error: the parts that
// the search in relative_pose.h is made of. Rays are unit vectors in their camera; errors are angles,
// radians. (Hartley and Zisserman, Multiple View Geometry, section 9.6, for the four motions of an essential
// matrix.)
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

Eigen::Matrix3d CrossMatrix(const Eigen::Vector3d& v);  // CrossMatrix(v) * w = v x w

Eigen::Matrix3d EssentialFromPose(const Rigid3& second_from_first);

// Distance of a pair from an essential matrix (first-order geometric error on the sphere).
double EpipolarError(const Eigen::Matrix3d& second_from_first_essential, const RayPair& pair);

// Rotation and the direction of translation.
struct Motion {
  Rigid3 second_from_first;
  Eigen::Matrix3d essential;
  double direction_sigma = 0;  // radians for residuals of unit variance, where it was refined
  explicit Motion(const Rigid3& pose) : second_from_first(pose), essential(EssentialFromPose(pose)) {}
};

// The motion of an essential matrix under which most of `pairs` lie in front of both cameras.
std::optional<Motion> BestMotion(const Eigen::Matrix3d& essential, std::span<const RayPair> pairs,
                                 const std::vector<int>& used);

double TruncatedCost(const Motion& motion, std::span<const RayPair> pairs, const std::vector<int>& used,
                     double gate);

// Truncated cost in which a pair that meets behind a camera, by more than `noise` of parallax can feign, is
// not explained at all.
double CostInFront(const Motion& motion, std::span<const RayPair> pairs, double gate, double noise);

// Levenberg-Marquardt on the truncated epipolar error over rotation and the direction of translation.
// Truncation, not Huber: outliers that pull a little pull towards motion along the axis, whose epipolar lines
// all are short of.
Motion RefineMotion(const Motion& initial, std::span<const RayPair> pairs, const std::vector<int>& used,
                    double gate, int iterations = 6);

}  // namespace ulf::tracking
