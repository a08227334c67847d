#include "core/geometry/rigid3.h"

#include <cmath>

namespace ulf {

Rigid3 Rigid3::FromMatrix(const Eigen::Matrix4d& target_from_source) {
  Rigid3 result;
  result.rotation =
      Eigen::Quaterniond(Eigen::Matrix3d(target_from_source.topLeftCorner<3, 3>())).normalized();
  result.translation = target_from_source.topRightCorner<3, 1>();
  return result;
}

Eigen::Matrix4d Rigid3::Matrix() const {
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  matrix.topLeftCorner<3, 3>() = RotationMatrix();
  matrix.topRightCorner<3, 1>() = translation;
  return matrix;
}

Rigid3 Interpolated(const Rigid3& a, const Rigid3& b, double share) {
  const Eigen::Quaterniond rotation = a.rotation.slerp(share, b.rotation);
  const Eigen::Vector3d center = (1 - share) * a.OriginInSource() + share * b.OriginInSource();
  return {rotation, -(rotation * center)};
}

Rigid3 LookAt(const Eigen::Vector3d& center_in_world, const Eigen::Vector3d& target_in_world,
              const Eigen::Vector3d& up_in_world) {
  const Eigen::Vector3d forward = (target_in_world - center_in_world).normalized();
  Eigen::Vector3d right = forward.cross(up_in_world);
  if (right.norm() < 1e-9 * up_in_world.norm()) right = forward.unitOrthogonal();  // looking along up
  right.normalize();
  const Eigen::Vector3d down = forward.cross(right);
  Eigen::Matrix3d rotation;
  rotation.row(0) = right;
  rotation.row(1) = down;
  rotation.row(2) = forward;
  Rigid3 cam_from_world;
  cam_from_world.rotation = Eigen::Quaterniond(rotation).normalized();
  cam_from_world.translation = -(cam_from_world.rotation * center_in_world);
  return cam_from_world;
}

double RotationAngle(const Eigen::Quaterniond& a_from_b) {
  return 2.0 * std::atan2(a_from_b.vec().norm(), std::abs(a_from_b.w()));
}

}  // namespace ulf
