#include "core/geometry/camera_model.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "core/base/error.h"

namespace ulf {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;
using Eigen::Vector3d;

// A distorted point on the normalised image plane and its derivative by the undistorted one.
struct Distorted {
  Vector2d point;
  Matrix2d by_undistorted;
};

Distorted DistortRadialTangential(const std::array<double, 5>& c, const Vector2d& p) {
  const auto [k1, k2, p1, p2, k3] = c;
  const double x = p.x(), y = p.y();
  const double r2 = x * x + y * y;
  const double radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3));
  const double radial_by_r2 = k1 + r2 * (2 * k2 + r2 * 3 * k3);
  Distorted d;
  d.point = {x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x),
             y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y};
  d.by_undistorted(0, 0) = radial + 2 * x * x * radial_by_r2 + 2 * p1 * y + 6 * p2 * x;
  d.by_undistorted(0, 1) = 2 * x * y * radial_by_r2 + 2 * p1 * x + 2 * p2 * y;
  d.by_undistorted(1, 0) = d.by_undistorted(0, 1);
  d.by_undistorted(1, 1) = radial + 2 * y * y * radial_by_r2 + 6 * p1 * y + 2 * p2 * x;
  return d;
}

// Returns the fisheye's image radius as a function of the angle from the axis, and its derivative.
std::pair<double, double> FisheyeRadius(const std::array<double, 5>& k, double theta) {
  const double t2 = theta * theta;
  const double radius = theta * (1 + t2 * (k[0] + t2 * (k[1] + t2 * (k[2] + t2 * k[3]))));
  const double slope = 1 + t2 * (3 * k[0] + t2 * (5 * k[1] + t2 * (7 * k[2] + t2 * 9 * k[3])));
  return {radius, slope};
}

// Returns a distorted point's derivative by (k1 k2 p1 p2 k3), at an undistorted point of the plane.
Eigen::Matrix<double, 2, 5> RadialTangentialByCoefficients(const Vector2d& p) {
  const double x = p.x(), y = p.y(), r2 = p.squaredNorm();
  Eigen::Matrix<double, 2, 5> j;
  j.col(0) = r2 * p;
  j.col(1) = r2 * r2 * p;
  j.col(2) = Vector2d(2 * x * y, r2 + 2 * y * y);
  j.col(3) = Vector2d(r2 + 2 * x * x, 2 * x * y);
  j.col(4) = r2 * r2 * r2 * p;
  return j;
}

Eigen::Matrix<double, 2, 5> FisheyeByCoefficients(const Vector3d& p) {
  const double rho = std::hypot(p.x(), p.y()), theta = std::atan2(rho, p.z()), t2 = theta * theta;
  Eigen::Matrix<double, 2, 5> j = Eigen::Matrix<double, 2, 5>::Zero();
  if (rho <= 1e-12) return j;
  double power = theta * t2;
  for (int i = 0; i < 4; ++i, power *= t2) j.col(i) = power / rho * p.head<2>();
  return j;
}

// A polynomial distortion is trusted out to where its radius stops growing.
bool GrowsUpTo(const std::array<double, 5>& c, double r2) {
  // Small coefficients, the usual case, cannot bring the slope to zero whatever their signs.
  if (r2 * (3 * std::abs(c[0]) + r2 * (5 * std::abs(c[1]) + r2 * 7 * std::abs(c[4]))) < 1) return true;
  // d(r·radial)/dr = 1 + 3 k1 r² + 5 k2 r⁴ + 7 k3 r⁶ must stay positive on [0, r].
  const auto slope = [&](double s) { return 1 + s * (3 * c[0] + s * (5 * c[1] + s * 7 * c[4])); };
  if (slope(r2) <= 0) return false;
  // The cubic in s can fall below zero in between, at its stationary points.
  const double a = 21 * c[4], b = 10 * c[1], d = 3 * c[0];
  const auto dips = [&](double s) { return s > 0 && s < r2 && slope(s) <= 0; };
  if (a == 0) return b == 0 || !dips(-d / b);
  const double discriminant = b * b - 4 * a * d;
  if (discriminant < 0) return true;
  const double root = std::sqrt(discriminant);
  return !dips((-b + root) / (2 * a)) && !dips((-b - root) / (2 * a));
}

bool FisheyeGrowsUpTo(const std::array<double, 5>& k, double theta) {
  constexpr int kSteps = 8;
  for (int i = 1; i <= kSteps; ++i)
    if (FisheyeRadius(k, theta * i / kSteps).second <= 0) return false;
  return true;
}

}  // namespace

CameraModel CameraModel::Pinhole(int width, int height, double focal_px) {
  return {.width = width,
          .height = height,
          .fx = focal_px,
          .fy = focal_px,
          .cx = 0.5 * width,
          .cy = 0.5 * height};
}

CameraModel CameraModel::FromOpenCv(int width, int height, double fx, double fy, double cx, double cy,
                                    Distortion distortion, const std::array<double, 5>& coefficients) {
  return {width, height, fx, fy, cx + 0.5, cy + 0.5, distortion, coefficients};
}

void CameraModel::Validate(const std::string& owner) const {
  if (width <= 0 || height <= 0)
    throw Error("{}: image size {}x{} is not positive; give the size of the photographs", owner, width,
                height);
  for (const double value : {fx, fy, cx, cy})
    if (!std::isfinite(value))
      throw Error("{}: an intrinsic parameter is not finite; calibrate again or correct the file", owner);
  constexpr double kShortest_px = 1e-3;  // shorter ones are zeros with rounding errors in a file
  if (fx < kShortest_px || fy < kShortest_px)
    throw Error("{}: focal lengths {} and {} px must be positive; calibrate again or correct the file", owner,
                fx, fy);
  for (const double value : coefficients)
    if (!std::isfinite(value))
      throw Error("{}: a distortion coefficient is not finite; calibrate again or correct the file", owner);
}

std::optional<Vector2d> CameraModel::ImgFromCam(const Vector3d& point_in_cam) const {
  return ImgFromCam(point_in_cam, nullptr);
}

std::optional<Vector2d> CameraModel::ImgFromCam(const Vector3d& point_in_cam,
                                                Eigen::Matrix<double, 2, 3>* img_by_point) const {
  const double x = point_in_cam.x(), y = point_in_cam.y(), z = point_in_cam.z();
  if (distortion == Distortion::kFisheye) {
    const double rho = std::hypot(x, y);
    const double theta = std::atan2(rho, z);
    if (!(rho + std::abs(z) > 0) || !FisheyeGrowsUpTo(coefficients, theta)) return std::nullopt;
    const auto [radius, slope] = FisheyeRadius(coefficients, theta);
    // On the axis the direction is undefined and the projection is that of a pinhole.
    const Vector2d unit = rho > 1e-12 ? Vector2d(x / rho, y / rho) : Vector2d(1, 0);
    const double radius_over_rho = rho > 1e-12 ? radius / rho : 1 / z;
    if (rho <= 1e-12 && z <= 0) return std::nullopt;
    if (img_by_point) {
      const double norm2 = rho * rho + z * z;
      const double radius_by_rho = slope * z / norm2;
      const double radius_by_z = -slope * rho / norm2;
      Eigen::Matrix<double, 2, 3> j;
      j.leftCols<2>() = radius_by_rho * unit * unit.transpose() +
                        radius_over_rho * (Matrix2d::Identity() - unit * unit.transpose());
      j.col(2) = radius_by_z * unit;
      if (rho <= 1e-12) j.leftCols<2>() = Matrix2d::Identity() / z;
      j.row(0) *= fx;
      j.row(1) *= fy;
      *img_by_point = j;
    }
    return Vector2d(fx * radius_over_rho * x + cx, fy * radius_over_rho * y + cy);
  }

  if (!(z > 1e-12)) return std::nullopt;
  const Vector2d plane(x / z, y / z);
  Distorted distorted{plane, Matrix2d::Identity()};
  if (distortion == Distortion::kRadialTangential) {
    if (!GrowsUpTo(coefficients, plane.squaredNorm())) return std::nullopt;
    distorted = DistortRadialTangential(coefficients, plane);
  }
  if (img_by_point) {
    Eigen::Matrix<double, 2, 3> plane_by_point;
    plane_by_point << 1 / z, 0, -plane.x() / z, 0, 1 / z, -plane.y() / z;
    *img_by_point = Vector2d(fx, fy).asDiagonal() * distorted.by_undistorted * plane_by_point;
  }
  return Vector2d(fx * distorted.point.x() + cx, fy * distorted.point.y() + cy);
}

std::optional<Vector2d> CameraModel::ImgFromCam(const Vector3d& point_in_cam,
                                                Eigen::Matrix<double, 2, 3>* img_by_point,
                                                Eigen::Matrix<double, 2, 9>* img_by_parameters) const {
  const auto img = ImgFromCam(point_in_cam, img_by_point);
  if (!img || !img_by_parameters) return img;
  Eigen::Matrix<double, 2, 9>& j = *img_by_parameters;
  j.setZero();
  j(0, 0) = (img->x() - cx) / fx;
  j(1, 1) = (img->y() - cy) / fy;
  j(0, 2) = j(1, 3) = 1;
  if (distortion == Distortion::kNone) return img;
  j.rightCols<5>() = distortion == Distortion::kFisheye
                         ? FisheyeByCoefficients(point_in_cam)
                         : RadialTangentialByCoefficients(point_in_cam.head<2>() / point_in_cam.z());
  j.row(0).tail<5>() *= fx;
  j.row(1).tail<5>() *= fy;
  return img;
}

std::optional<Vector3d> CameraModel::RayFromImg(const Vector2d& img) const {
  const Vector2d distorted((img.x() - cx) / fx, (img.y() - cy) / fy);
  constexpr int kMaxIterations = 50;
  constexpr double kTolerance = 1e-14;

  if (distortion == Distortion::kNone) return Vector3d(distorted.x(), distorted.y(), 1).normalized();

  if (distortion == Distortion::kFisheye) {
    const double radius = distorted.norm();
    if (radius < 1e-14) return Vector3d::UnitZ();
    double theta = std::min(radius, 0.5 * M_PI);
    bool converged = false;
    for (int i = 0; i < kMaxIterations && !converged; ++i) {
      const auto [value, slope] = FisheyeRadius(coefficients, theta);
      if (slope <= 0) return std::nullopt;
      const double step = (value - radius) / slope;
      theta -= step;
      converged = std::abs(step) < kTolerance * std::max(1.0, radius);
    }
    if (!converged || theta < 0 || theta > M_PI || !FisheyeGrowsUpTo(coefficients, theta))
      return std::nullopt;
    const Vector2d unit = distorted / radius;
    return Vector3d(unit.x() * std::sin(theta), unit.y() * std::sin(theta), std::cos(theta));
  }

  Vector2d plane = distorted;
  bool converged = false;
  for (int i = 0; i < kMaxIterations && !converged; ++i) {
    const Distorted d = DistortRadialTangential(coefficients, plane);
    Vector2d step = d.by_undistorted.inverse() * (d.point - distorted);
    if (!step.allFinite()) return std::nullopt;
    // A full Newton step may go past the fold of a strong distortion.
    const double limit = 0.5 + 0.5 * plane.norm();
    if (step.norm() > limit) step *= limit / step.norm();
    plane -= step;
    converged = step.norm() < kTolerance * std::max(1.0, plane.norm());
  }
  if (!converged || !GrowsUpTo(coefficients, plane.squaredNorm())) return std::nullopt;
  return Vector3d(plane.x(), plane.y(), 1).normalized();
}

double CameraModel::DistortionExtent() const {
  const bool fisheye = distortion == Distortion::kFisheye;
  const auto holds = [&](double extent) {
    return fisheye ? FisheyeGrowsUpTo(coefficients, extent) : GrowsUpTo(coefficients, extent);
  };
  const double most = fisheye ? M_PI : 100.0;  // r = 10: 84 degrees from the axis
  constexpr int kSteps = 200, kHalvings = 40;
  int step = 1;
  while (step <= kSteps && holds(most * step / kSteps)) ++step;
  if (step > kSteps) return fisheye ? M_PI : 1e30;
  double inside = most * (step - 1) / kSteps, outside = most * step / kSteps;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = 0.5 * (inside + outside);
    (holds(middle) ? inside : outside) = middle;
  }
  return inside;
}

CameraModel CameraModel::ScaledTo(int new_width, int new_height) const {
  CameraModel scaled = *this;
  const double sx = static_cast<double>(new_width) / width, sy = static_cast<double>(new_height) / height;
  scaled.width = new_width;
  scaled.height = new_height;
  scaled.fx *= sx;
  scaled.cx *= sx;
  scaled.fy *= sy;
  scaled.cy *= sy;
  return scaled;
}

CameraModel CameraModel::WithoutDistortion() const {
  CameraModel plain = *this;
  plain.distortion = Distortion::kNone;
  plain.coefficients = {};
  return plain;
}

double CameraModel::MaxRayAngle() const {
  double largest = 0;
  for (const double u : {0.0, static_cast<double>(width)})
    for (const double v : {0.0, static_cast<double>(height)}) {
      const auto ray = RayFromImg({u, v});
      const double angle = ray ? std::acos(std::clamp(ray->z(), -1.0, 1.0))
                               : std::atan(std::hypot((u - cx) / fx, (v - cy) / fy));
      largest = std::max(largest, angle);
    }
  return largest;
}

}  // namespace ulf
