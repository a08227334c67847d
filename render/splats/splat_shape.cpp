#include "render/splats/splat_shape.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>

namespace ulf::render {
namespace {

constexpr float kThickness = 0.1f;  // over the smaller extent along the surface

// Returns the rotation of the same ellipsoid, its axes renamed, that is nearest to none: the sizes follow.
// SPZ up to version 2 stores x, y and z of a quaternion in 8 bits, so that w is inexact where it is small.
Gaussian::Rotation UprightRotation(const Eigen::Matrix3f& axes, const Eigen::Vector3f& scale,
                                   Eigen::Vector3f& scale_of_rotation) {
  static constexpr std::array<std::array<int, 3>, 6> kOrders{
      {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {0, 2, 1}, {2, 1, 0}, {1, 0, 2}}};
  float best = -4;
  Eigen::Matrix3f rotation = axes;
  for (const auto& order : kOrders)
    for (const float x : {-1.0f, 1.0f})
      for (const float y : {-1.0f, 1.0f}) {
        Eigen::Matrix3f renamed;
        renamed.col(0) = x * axes.col(order[0]);
        renamed.col(1) = y * axes.col(order[1]);
        renamed.col(2) = renamed.col(0).cross(renamed.col(1));
        if (renamed.trace() <= best) continue;
        best = renamed.trace();
        rotation = renamed;
        scale_of_rotation = {scale[order[0]], scale[order[1]], scale[order[2]]};
      }
  Gaussian::Rotation quaternion(rotation);
  quaternion.normalize();
  if (quaternion.w() < 0) quaternion.coeffs() *= -1;
  return quaternion;
}

// Returns the width that the low-pass of renderers leaves for the Gaussian itself.
float OverSpacing(const SplatForm& form, float size_px) {
  constexpr float kLowPass_px2 = 0.3f, kLeast = 0.15f;
  return std::sqrt(std::max(kLeast * kLeast, form.spread * form.spread - kLowPass_px2 / (size_px * size_px)));
}

}  // namespace

Gaussian FlatGaussian(const SplatForm& form, const SurfaceCell& cell) {
  const Eigen::Vector3f right = cell.normal.unitOrthogonal(), up = cell.normal.cross(right);
  Eigen::Matrix2f spans;
  spans << cell.across.dot(right), cell.down.dot(right), cell.across.dot(up), cell.down.dot(up);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2f> ellipse(spans * spans.transpose());
  const Eigen::Vector2f sizes =
      OverSpacing(form, cell.size_px) * ellipse.eigenvalues().cwiseMax(0).cwiseSqrt();
  Eigen::Matrix3f axes;
  axes.col(0) = ellipse.eigenvectors()(0, 0) * right + ellipse.eigenvectors()(1, 0) * up;
  axes.col(1) = ellipse.eigenvectors()(0, 1) * right + ellipse.eigenvectors()(1, 1) * up;
  axes.col(2) = cell.normal;
  Gaussian gaussian;
  gaussian.position_in_world = cell.point;
  gaussian.world_from_axes =
      UprightRotation(axes, {sizes[0], sizes[1], kThickness * sizes[0]}, gaussian.scale);
  gaussian.opacity = form.opacity;
  for (int c = 0; c < 3; ++c)
    gaussian.harmonics[0][c] = (static_cast<float>(cell.bgr[2 - c]) / 255 - 0.5f) / kConstantHarmonic;
  return gaussian;
}

}  // namespace ulf::render
