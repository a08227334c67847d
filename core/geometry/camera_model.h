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
  // Makes a camera from a principal point whose pixel centres are at integers (OpenCV, Kalibr, ROS).
  static CameraModel FromOpenCv(int width, int height, double fx, double fy, double cx, double cy,
                                Distortion distortion = Distortion::kNone,
                                const std::array<double, 5>& coefficients = {});

  // Throws Error naming `owner` (a file, a camera) and a size or focal length not positive, a
  // value not finite.
  void Validate(const std::string& owner) const;

  // Returns the image point in px of a point, which may lie outside the image; none if the point is behind
  // the camera (a fisheye sees there, too), or if the distortion polynomial no longer grows (the image point
  // would belong to a ray nearer the axis).
  std::optional<Eigen::Vector2d> ImgFromCam(const Eigen::Vector3d& point_in_cam) const;

  // Does the same, with the derivative by the point. A null pointer asks for no derivative.
  std::optional<Eigen::Vector2d> ImgFromCam(const Eigen::Vector3d& point_in_cam,
                                            Eigen::Matrix<double, 2, 3>* img_by_point) const;

  // Does the same, with the derivative by fx fy cx cy and the five coefficients as well.
  std::optional<Eigen::Vector2d> ImgFromCam(const Eigen::Vector3d& point_in_cam,
                                            Eigen::Matrix<double, 2, 3>* img_by_point,
                                            Eigen::Matrix<double, 2, 9>* img_by_parameters) const;

  // Returns the unit ray through an image point; none if the distortion cannot be inverted.
  std::optional<Eigen::Vector3d> RayFromImg(const Eigen::Vector2d& img) const;

  // Returns how far from the axis the distortion polynomial grows: x² + y² of the ray (x, y, 1), 1e30 if it
  // grows everywhere; for a fisheye the angle in radians, at most pi. ImgFromCam() returns none beyond.
  double DistortionExtent() const;

  bool Contains(const Eigen::Vector2d& img) const {
    return img.x() >= 0 && img.y() >= 0 && img.x() < width && img.y() < height;
  }

  // Returns the same camera with images resized to another width and height.
  CameraModel ScaledTo(int new_width, int new_height) const;
  // Returns the same camera without its distortion.
  CameraModel WithoutDistortion() const;

  double MeanFocalPx() const { return 0.5 * (fx + fy); }
  // Returns the largest angle between the axis and a ray of the image, in radians.
  double MaxRayAngle() const;

  bool operator==(const CameraModel&) const = default;
  auto operator<=>(const CameraModel&) const = default;  // NOLINT(modernize-use-nullptr)
};

}  // namespace ulf
