#include "tests/support/bound_oracle.h"
#include "tests/support/floors.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

namespace ulf::test {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::optional<Vector2d> Project(const CriterionView& view, const Vector3d& point_in_world) {
  const Vector3d p = view.cam_from_world * (point_in_world - view.center_in_world);
  if (p.z() <= 0) return std::nullopt;
  return Vector2d(view.fx * p.x() / p.z() + view.cx, view.fy * p.y() / p.z() + view.cy);
}

Vector3d Ray(const CriterionView& view, const Vector2d& img) {
  const Vector3d in_cam((img.x() - view.cx) / view.fx, (img.y() - view.cy) / view.fy, 1);
  return (view.cam_from_world.transpose() * in_cam).normalized();
}

// Half the chord that the ray through `img` cuts from the sphere, squared: negative past the sphere.
double HalfChordSquared(const CriterionView& view, const Subject& subject, const Vector2d& img) {
  const Vector3d to_center = subject.center_in_world - view.center_in_world;
  return subject.radius * subject.radius - Ray(view, img).cross(to_center).squaredNorm();
}

// Points of the circle of tangency of `view`'s cone around the sphere.
std::vector<Vector3d> TangentPoints(const CriterionView& view, const Subject& subject, int count) {
  const Vector3d to_view = view.center_in_world - subject.center_in_world;
  const double ratio = subject.radius / to_view.norm();
  std::vector<Vector3d> points;
  if (ratio >= 1) return points;
  const Vector3d axis = to_view.normalized(), x = axis.unitOrthogonal(), y = axis.cross(x);
  for (int i = 0; i < count; ++i) {
    const double angle = 2 * M_PI * i / count;
    points.push_back(subject.center_in_world + subject.radius * ratio * axis +
                     subject.radius * std::sqrt(1 - ratio * ratio) *
                         (std::cos(angle) * x + std::sin(angle) * y));
  }
  return points;
}

double LongestDistance(const std::vector<Vector2d>& points) {
  double longest = 0;
  for (std::size_t i = 0; i < points.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) longest = std::max(longest, (points[i] - points[j]).squaredNorm());
  return std::sqrt(longest);
}

bool InFrame(const CriterionView& view, const Vector2d& img) {
  return img.x() >= 0 && img.y() >= 0 && img.x() <= view.width && img.y() <= view.height;
}

}  // namespace

double OraclePixelErrorPx(const CriterionView& recorded, const CriterionView& candidate,
                          const Subject& subject, const Vector2d& img, int cone_rays) {
  if (HalfChordSquared(recorded, subject, img) < 0) return 0;
  const Vector3d to_center = subject.center_in_world - recorded.center_in_world;
  std::vector<Vector2d> images;
  for (int i = 0; i < cone_rays; ++i) {
    const double angle = 2 * M_PI * i / cone_rays;
    const Vector2d step(std::cos(angle), std::sin(angle));
    double reach = 1;
    if (HalfChordSquared(recorded, subject, img + step) < 0) {  // past the sphere: back to its rim
      double inside = 0;
      for (int k = 0; k < 40; ++k) {
        const double middle = 0.5 * (inside + reach);
        (HalfChordSquared(recorded, subject, img + middle * step) < 0 ? reach : inside) = middle;
      }
      reach = inside;
    }
    const Vector3d ray = Ray(recorded, img + reach * step);
    const double half = std::sqrt(std::max(0.0, HalfChordSquared(recorded, subject, img + reach * step)));
    for (const double t : {ray.dot(to_center) - half, ray.dot(to_center) + half}) {
      const auto image = Project(candidate, recorded.center_in_world + std::max(0.0, t) * ray);
      if (!image) return kInfinity;
      images.push_back(*image);
    }
  }
  for (const Vector3d& point : TangentPoints(candidate, subject, cone_rays)) {
    const auto in_recorded = Project(recorded, point), in_candidate = Project(candidate, point);
    if (in_recorded && in_candidate && (*in_recorded - img).norm() <= 1) images.push_back(*in_candidate);
  }
  return LongestDistance(images);
}

double OracleLineErrorPx(const CriterionView& recorded, const CriterionView& candidate,
                         const Subject& subject, const Vector2d& img, const Vector2d& step, int samples) {
  const Vector3d to_center = subject.center_in_world - recorded.center_in_world;
  std::vector<Vector2d> images;
  for (int i = 0; i <= samples; ++i) {
    const Vector2d pixel = img + (2.0 * i / samples - 1) * step;
    const double half_squared = HalfChordSquared(recorded, subject, pixel);
    if (half_squared < 0) continue;
    const Vector3d ray = Ray(recorded, pixel);
    for (const double side : {-1.0, 1.0}) {
      const double t = ray.dot(to_center) + side * std::sqrt(half_squared);
      const auto image = Project(candidate, recorded.center_in_world + std::max(0.0, t) * ray);
      if (!image) return kInfinity;
      images.push_back(*image);
    }
  }
  return LongestDistance(images);
}

double OracleBoundPx(const CriterionView& recorded, const CriterionView& candidate, const Subject& subject,
                     const BoundOracleOptions& options) {
  const Vector3d to_center = subject.center_in_world - recorded.center_in_world;
  const double largest_angle = std::asin(std::min(1.0, subject.radius / to_center.norm()));
  const Vector3d axis = to_center.normalized(), x = axis.unitOrthogonal(), y = axis.cross(x);
  double worst = -1;
  Vector2d worst_img = Vector2d::Zero();
  const auto look_at = [&](const Vector2d& img) {
    if (!InFrame(recorded, img) || HalfChordSquared(recorded, subject, img) < 0) return false;
    const double error = OraclePixelErrorPx(recorded, candidate, subject, img, options.cone_rays);
    if (error <= worst) return false;
    worst = error;
    worst_img = img;
    return true;
  };
  for (int ring = 0; ring <= options.rings; ++ring)
    for (int k = 0; k < (ring == 0 ? 1 : options.pixels_on_a_ring); ++k) {
      const double angle = largest_angle * ring / options.rings * (1 - 1e-9);
      const double around = 2 * M_PI * (k + 0.5 * (ring % 2)) / options.pixels_on_a_ring;
      const Vector3d ray =
          std::cos(angle) * axis + std::sin(angle) * (std::cos(around) * x + std::sin(around) * y);
      if (const auto img = Project(recorded, recorded.center_in_world + ray)) look_at(*img);
    }
  if (worst < 0) return kInfinity;
  if (!options.refine) return worst;
  double step = 2 * largest_angle * recorded.fx / options.rings;
  while (step > 0.01) {
    bool better = false;
    const Vector2d around(worst_img.x(), worst_img.y());  // look_at() moves worst_img
    for (int k = 0; k < 12; ++k) {
      const double angle = 2 * M_PI * k / 12;
      better |= look_at(around + step * Vector2d(std::cos(angle), std::sin(angle)));
    }
    if (!better) step *= 0.5;
  }
  return worst;
}

double SilhouettePx(const CriterionView& view, const Subject& subject) {
  std::vector<Vector2d> images;
  for (const Vector3d& point : TangentPoints(view, subject, 96)) {
    const auto image = Project(view, point);
    if (!image) return kInfinity;
    images.push_back(*image);
  }
  return images.empty() ? kInfinity : LongestDistance(images);
}

}  // namespace ulf::test
