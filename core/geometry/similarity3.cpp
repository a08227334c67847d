#include "core/geometry/similarity3.h"

#include <cmath>

#include "core/geometry/small_matrices.h"

namespace ulf {

using Eigen::Matrix3d;
using Eigen::Vector3d;

Similarity3 Perturbed(const Similarity3& target_from_source, const Eigen::Matrix<double, 7, 1>& delta) {
  const Vector3d turn = delta.head<3>();
  const double angle = turn.norm();
  const Vector3d axis = angle > 0 ? Vector3d(turn / angle) : Vector3d(Vector3d::UnitX());
  const Similarity3 step{std::exp(delta(6)), Eigen::AngleAxisd(angle, axis).toRotationMatrix(),
                         delta.segment<3>(3)};
  return step * target_from_source;
}

std::optional<Similarity3> AlignPoints(std::span<const Vector3d> source, std::span<const Vector3d> target,
                                       bool rigid) {
  const auto count = static_cast<Eigen::Index>(std::min(source.size(), target.size()));
  if (count < 3) return std::nullopt;
  Eigen::Matrix3Xd from = Eigen::Matrix3Xd::Map(source.data()->data(), 3, count),
                   to = Eigen::Matrix3Xd::Map(target.data()->data(), 3, count);
  const Vector3d source_mean = from.rowwise().mean(), target_mean = to.rowwise().mean();
  from.colwise() -= source_mean;
  to.colwise() -= target_mean;
  const Matrix3d covariance = to * from.transpose();
  const double variance = from.squaredNorm();
  const SingularValues3 svd = SingularValuesOf(covariance);
  const Vector3d singular = svd.values;
  if (!(variance > 0) || !(singular(1) > 1e-9 * singular(0))) return std::nullopt;
  Vector3d signs(1, 1, 1);
  if (svd.u.determinant() * svd.v.determinant() < 0) signs(2) = -1;
  Similarity3 similarity;
  similarity.rotation = svd.u * signs.asDiagonal() * svd.v.transpose();
  if (!rigid) similarity.scale = singular.dot(signs) / variance;
  similarity.translation = target_mean - similarity.scale * (similarity.rotation * source_mean);
  return similarity;
}

}  // namespace ulf
