// A rigid transform in three dimensions. Its name says target and source: `cam_from_world` maps a point from
// world to camera coordinates. Cameras are right-handed, x right, y down, z forward.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace ulf {

struct Rigid3 {
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();  // unit
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();

  static Rigid3 FromMatrix(const Eigen::Matrix4d& target_from_source);

  Eigen::Matrix3d RotationMatrix() const { return rotation.toRotationMatrix(); }
  Eigen::Matrix4d Matrix() const;

  Rigid3 Inverse() const {
    const Eigen::Quaterniond inverse = rotation.conjugate();
    return {inverse, -(inverse * translation)};
  }

  // Returns the target frame's origin in the source frame: for `cam_from_world`, the camera's centre.
  Eigen::Vector3d OriginInSource() const { return -(rotation.conjugate() * translation); }

  // Returns a target-frame direction in the source frame. For `cam_from_world`, UnitZ gives the optical axis.
  Eigen::Vector3d DirectionInSource(const Eigen::Vector3d& direction) const {
    return rotation.conjugate() * direction;
  }
};

inline Eigen::Vector3d operator*(const Rigid3& b_from_a, const Eigen::Vector3d& point_in_a) {
  return b_from_a.rotation * point_in_a + b_from_a.translation;
}

inline Rigid3 operator*(const Rigid3& c_from_b, const Rigid3& b_from_a) {
  return {(c_from_b.rotation * b_from_a.rotation).normalized(),
          c_from_b.rotation * b_from_a.translation + c_from_b.translation};
}

// Interpolates between two poses `cam_from_world` at a share (0 to 1) of the way from `a` to `b`: the
// rotation by slerp, the camera's centre on a straight line.
Rigid3 Interpolated(const Rigid3& a, const Rigid3& b, double share);

// Returns the pose cam_from_world of a camera that looks at a target, with `up_in_world` upwards in its
// image; if it looks along that direction, its roll is arbitrary.
Rigid3 LookAt(const Eigen::Vector3d& center_in_world, const Eigen::Vector3d& target_in_world,
              const Eigen::Vector3d& up_in_world);

// Returns the rotation angle of a_from_b, in radians, 0 to pi.
double RotationAngle(const Eigen::Quaterniond& a_from_b);

}  // namespace ulf
