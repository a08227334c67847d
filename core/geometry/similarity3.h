// A similarity transform (rotation, translation, scale). Images alone determine poses up to such a transform.
//
// `target_from_source` as for Rigid3, with the scale first: target = scale * rotation * source + translation.
// Scaling the world about the camera does not change the image, so WithoutScale() turns a pose that a
// similarity moved into a rigid one.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>
#include <span>

#include "core/geometry/rigid3.h"

namespace ulf {

struct Similarity3 {
  double scale = 1;
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();

  static Similarity3 FromRigid(const Rigid3& rigid) { return {1, rigid.RotationMatrix(), rigid.translation}; }
  Similarity3 Inverse() const {
    return {1 / scale, rotation.transpose(), -(rotation.transpose() * translation) / scale};
  }
  // For a camera, returns the rigid pose that sees the same image, in units of the source.
  Rigid3 WithoutScale() const { return {Eigen::Quaterniond(rotation).normalized(), translation / scale}; }
};

inline Eigen::Vector3d operator*(const Similarity3& target_from_source, const Eigen::Vector3d& point) {
  return target_from_source.scale * (target_from_source.rotation * point) + target_from_source.translation;
}

inline Similarity3 operator*(const Similarity3& c_from_b, const Similarity3& b_from_a) {
  return {c_from_b.scale * b_from_a.scale, c_from_b.rotation * b_from_a.rotation,
          c_from_b * b_from_a.translation};
}

// Returns step * target_from_source; delta is the step's rotation vector (radians), translation, log(scale).
Similarity3 Perturbed(const Similarity3& target_from_source, const Eigen::Matrix<double, 7, 1>& delta);

// Returns the similarity that maps each point of `source` to that of `target` at its index, with least
// squared error (Umeyama 1991), of scale 1 if `rigid`; none for fewer than three points or points on a line.
std::optional<Similarity3> AlignPoints(std::span<const Eigen::Vector3d> source,
                                       std::span<const Eigen::Vector3d> target, bool rigid = false);

}  // namespace ulf
