#include "tracking/estimation/focal_change.h"

#include <Eigen/Cholesky>
#include <cmath>

namespace ulf::tracking {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Matrix7d = Eigen::Matrix<double, 7, 7>;
using Vector7d = Eigen::Matrix<double, 7, 1>;

constexpr std::size_t kFewest = 30;  // points that are needed. Guessed
// Steps of Gauss-Newton from the pose that fits the camera's own focal length. Guessed.
constexpr int kSteps = 2;

struct Equations {
  Matrix7d normal = Matrix7d::Zero();
  Vector7d gradient = Vector7d::Zero();
  double squares = 0;  // weighted
  int used = 0;
};

// The image is magnified about the principal point.
Equations Linearized(const CameraModel& camera, std::span<const PointObservation> observations,
                     const Rigid3& pose, double log_ratio) {
  Equations equations;
  const Vector2d center(camera.cx, camera.cy);
  const double ratio = std::exp(log_ratio);
  for (const PointObservation& o : observations) {
    const Vector3d point = pose * o.point_in_world;
    Eigen::Matrix<double, 2, 3> img_by_point;
    const auto img = camera.ImgFromCam(point, &img_by_point);
    if (!img) continue;
    const Vector2d from_center = ratio * (*img - center);
    const Vector2d residual = (center + from_center - o.img) / o.sigma_px;
    const double length = residual.norm();
    const double weight = length <= kSigmas95 ? 1 : kSigmas95 / length;
    for (int row = 0; row < 2; ++row) {
      const Vector3d move = ratio * img_by_point.row(row), turn = point.cross(move);
      Vector7d entries = Vector7d::Constant(from_center(row) / o.sigma_px);
      for (int k = 0; k < 3; ++k) {
        entries(k) = turn(k) / o.sigma_px;
        entries(k + 3) = move(k) / o.sigma_px;
      }
      equations.normal.noalias() += weight * entries * entries.transpose();
      equations.gradient += weight * residual(row) * entries;
    }
    equations.squares += weight * length * length;
    ++equations.used;
  }
  return equations;
}

}  // namespace

std::optional<FocalChange> MeasureFocalChange(const CameraModel& camera,
                                              std::span<const PointObservation> observations,
                                              const Rigid3& cam_from_world) {
  if (observations.size() < kFewest) return std::nullopt;
  Rigid3 pose = cam_from_world;
  FocalChange change;
  for (int step = 0;; ++step) {
    const Equations equations = Linearized(camera, observations, pose, change.log_ratio);
    const Eigen::LDLT<Matrix7d> factors(equations.normal);
    if (factors.info() != Eigen::Success) return std::nullopt;
    if (step == kSteps) {
      const double variance = factors.solve(Vector7d::Unit(6))(6);
      const double noise2 = equations.squares / std::max(1, 2 * equations.used - 7);
      if (!(variance > 0) || !std::isfinite(variance)) return std::nullopt;
      change.sigma = std::sqrt(variance * noise2);
      return change;
    }
    const Vector7d moved = -factors.solve(equations.gradient);
    if (!moved.allFinite()) return std::nullopt;
    pose = Perturbed(pose, moved.head<6>());
    change.log_ratio += moved(6);
  }
}

}  // namespace ulf::tracking
