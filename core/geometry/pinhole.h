// A pinhole camera's projection, without distortion and without regard to the image's size: it uses
// CameraModel's fx fy cx cy alone. Units are pixels, the camera frame has x right, y down, z forward.
#pragma once

#include <Eigen/Core>

#include "core/geometry/camera_model.h"

namespace ulf {

// Returns the ray (x, y, 1) through an image point.
inline Eigen::Vector3d PinholeRay(const CameraModel& camera, const Eigen::Vector2d& img) {
  return {(img.x() - camera.cx) / camera.fx, (img.y() - camera.cy) / camera.fy, 1.0};
}

// Returns the ray (x, y, 1) through a pixel's centre.
inline Eigen::Vector3d PinholeRay(const CameraModel& camera, int x, int y) {
  return {(x + 0.5 - camera.cx) / camera.fx, (y + 0.5 - camera.cy) / camera.fy, 1.0};
}

// Returns the image point of a point whose z is not 0.
inline Eigen::Vector2d PinholeImg(const CameraModel& camera, const Eigen::Vector3d& point_in_cam) {
  return {camera.fx * point_in_cam.x() / point_in_cam.z() + camera.cx,
          camera.fy * point_in_cam.y() / point_in_cam.z() + camera.cy};
}

// Returns the matrix that takes rays (x, y, 1) to homogeneous image points.
inline Eigen::Matrix3d PinholeMatrix(const CameraModel& camera) {
  Eigen::Matrix3d matrix;
  matrix << camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1;
  return matrix;
}

}  // namespace ulf
