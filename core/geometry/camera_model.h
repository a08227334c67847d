// A camera's intrinsics: pinhole with OpenCV's radial-tangential or fisheye distortion.
//
// Pixel centres are at integer + 0.5, as in COLMAP and nerfstudio. OpenCV, Kalibr and ROS have them at
// integers: readers of their files add 0.5 to the principal point. Lengths are pixels, rays are in the camera
// frame (x right, y down, z forward).
//   Radial-tangential: Brown 1966 as in OpenCV's calib3d (k1 k2 p1 p2 k3).
//   Fisheye: Kannala and Brandt 2006 as in OpenCV's fisheye module (k1 k2 k3 k4).
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>

namespace ulf {

enum class Distortion { kNone, kRadialTangential, kFisheye };

struct CameraModel {
  int width = 0;
  int height = 0;
  double fx = 0, fy = 0;
  double cx = 0, cy = 0;
  Distortion distortion = Distortion::kNone;
  // kRadialTangential: k1 k2 p1 p2 k3. kFisheye: k1 k2 k3 k4 0. kNone: unused.
  std::array<double, 5> coefficients{};

  static CameraModel Pinhole(int width, int height, double focal_px);
  // Makes a camera from a principal point counted from integer pixel centres (OpenCV, Kalibr, ROS).
  static CameraModel FromOpenCv(int width, int height, double fx, double fy, double cx, double cy,
                                Distortion distortion = Distortion::kNone,
                                const std::array<double, 5>& coefficients = {});

  // Throws Error naming what is out of range (sizes, focal lengths, anything not finite).
  void Validate(const std::string& owner) const;

  // Returns the image point in px of a point in front of the camera; none behind it, or if the distortion
  // polynomial no longer grows (the image point would belong to a ray nearer the axis). The result may lie
  // outside the image.
  std::optional<Eigen::Vector2d> ImgFromCam(const Eigen::Vector3d& point_in_cam) const;

  // Does the same, with the 2x3 derivative by the point.
  std::optional<Eigen::Vector2d> ImgFromCam(const Eigen::Vector3d& point_in_cam,
                                            Eigen::Matrix<double, 2, 3>* img_by_point) const;

  // Does the same, with the derivative by the parameters as well: fx fy cx cy, then the five coefficients.
  std::optional<Eigen::Vector2d> ImgFromCam(const Eigen::Vector3d& point_in_cam,
                                            Eigen::Matrix<double, 2, 3>* img_by_point,
                                            Eigen::Matrix<double, 2, 9>* img_by_parameters) const;

  // Returns the unit ray through an image point; none if the distortion cannot be inverted.
  std::optional<Eigen::Vector3d> RayFromImg(const Eigen::Vector2d& img) const;

  // Returns how far from the axis the distortion polynomial grows: the squared distance at depth 1, or the
  // fisheye's angle in radians. ImgFromCam() has no image for points beyond. It is 1e30 or pi if it grows
  // everywhere.
  double DistortionExtent() const;

  bool Contains(const Eigen::Vector2d& img) const {
    return img.x() >= 0 && img.y() >= 0 && img.x() < width && img.y() < height;
  }

  // Returns the same camera with images resized to another width and height.
  CameraModel ScaledTo(int new_width, int new_height) const;
  // Returns the same camera without its distortion.
  CameraModel WithoutDistortion() const;

  double MeanFocalPx() const { return 0.5 * (fx + fy); }
  // Returns the largest angle between the axis and a ray of the image, half the diagonal field of view, in
  // radians.
  double MaxRayAngle() const;

  bool operator==(const CameraModel&) const = default;
  auto operator<=>(const CameraModel&) const = default;
};

}  // namespace ulf
