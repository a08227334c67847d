#include "core/light_field/points/point_tracks.h"

#include <algorithm>
#include <limits>

#include "core/geometry/small_matrices.h"

namespace ulf {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

std::optional<Vector3d> NearestToRays(std::span<const PosedObservation> observations) {
  Matrix3d normal = Matrix3d::Zero();
  Vector3d right = Vector3d::Zero();
  int rays = 0;
  for (const PosedObservation& observation : observations) {
    const auto ray = observation.camera->RayFromImg(observation.in_img);
    if (!ray) continue;
    const Vector3d along = observation.cam_from_world->DirectionInSource(*ray);
    const Matrix3d across = Matrix3d::Identity() - along * along.transpose();
    normal += across;
    right += across * observation.cam_from_world->OriginInSource();
    ++rays;
  }
  if (rays < 2) return std::nullopt;
  // Rays within a twentieth of a degree of each other do not determine a point. Guessed.
  constexpr double kMinMeanSquaredSine = 1e-6;
  const Eigenvalues3 solver = EigenvaluesOf(normal);
  if (solver.values(0) < kMinMeanSquaredSine * rays) return std::nullopt;
  return Vector3d(solver.vectors *
                  solver.values.cwiseInverse().cwiseProduct(solver.vectors.transpose() * right));
}

// Returns one Gauss-Newton step under Huber's loss; zero if too few views see the point.
Vector3d StepFrom(std::span<const PosedObservation> observations, const Vector3d& point) {
  // Threshold of Huber's loss. Guessed: observations are good to less than a pixel.
  constexpr double kDoubtPx = 1;
  Matrix3d normal = Matrix3d::Zero();
  Vector3d right = Vector3d::Zero();
  for (const PosedObservation& observation : observations) {
    Eigen::Matrix<double, 2, 3> img_by_cam;
    const auto img = observation.camera->ImgFromCam(*observation.cam_from_world * point, &img_by_cam);
    if (!img) continue;
    const Eigen::Matrix<double, 2, 3> j = img_by_cam * observation.cam_from_world->RotationMatrix();
    const Vector2d error = observation.in_img - *img;
    const double weight = std::min(1.0, kDoubtPx / std::max(1e-12, error.norm()));
    normal += weight * j.transpose() * j;
    right += weight * j.transpose() * error;
  }
  const Vector3d step = SolveNormal(normal, right);
  return step.allFinite() ? step : Vector3d(Vector3d::Zero());
}

}  // namespace

void FitPointsOf(const std::set<int>& view_ids, LightField& light_field) {
  if (view_ids.empty()) return;
  std::erase_if(light_field.points, [&](ScenePoint& point) {
    const bool moved = std::ranges::any_of(
        point.track, [&](const ViewObservation& seen) { return view_ids.contains(seen.view_id); });
    if (!moved) return false;
    std::vector<PosedObservation> observations;
    for (const ViewObservation& seen : point.track)
      if (const PosedObservation observation = PosedObservationOf(seen, light_field); observation.camera)
        observations.push_back(observation);
    const auto position = FitPoint(observations);
    if (position) point.position_in_world = *position;
    return !position;
  });
}

std::size_t MeasurePoints(LightField& light_field) {
  std::size_t misplaced = 0;
  for (ScenePoint& point : light_field.points) {
    double sum_px = 0;
    std::erase_if(point.track, [&](const ViewObservation& seen) {
      const PosedObservation observation = PosedObservationOf(seen, light_field);
      if (!observation.camera) return true;
      const double error_px = ReprojectionErrorPx(observation, point.position_in_world);
      if (!(error_px <= kMostTrackErrorPx)) {
        ++misplaced;
        return true;
      }
      sum_px += error_px;
      return false;
    });
    if (point.track.size() < 2) point.track.clear();
    point.error_px = point.track.empty() ? 0 : sum_px / static_cast<double>(point.track.size());
  }
  return misplaced;
}

PointStatistics StatisticsOf(const std::vector<ScenePoint>& points) {
  PointStatistics statistics;
  statistics.points = points.size();
  double sum_px = 0;
  for (const ScenePoint& point : points) {
    statistics.tracked += !point.track.empty();
    statistics.observations += point.track.size();
    sum_px += point.error_px * static_cast<double>(point.track.size());
  }
  if (statistics.observations == 0) return statistics;
  const double observations = static_cast<double>(statistics.observations);
  statistics.mean_track_length = observations / static_cast<double>(statistics.tracked);
  statistics.mean_error_px = sum_px / observations;
  return statistics;
}

std::optional<Vector3d> FitPoint(std::span<const PosedObservation> observations) {
  auto point = NearestToRays(observations);
  if (!point) return std::nullopt;
  constexpr int kIterations = 8;
  for (int i = 0; i < kIterations; ++i) {
    const Vector3d step = StepFrom(observations, *point);
    *point += step;
    if (step.norm() < 1e-9 * (1 + point->norm())) break;
  }
  int shown = 0;
  for (const PosedObservation& observation : observations)
    shown += (*observation.cam_from_world * *point).z() > 0;
  if (!point->allFinite() || shown < 2) return std::nullopt;
  return point;
}

PosedObservation PosedObservationOf(const ViewObservation& seen, const LightField& light_field) {
  const View* view = light_field.FindView(seen.view_id);
  if (!view) return {};
  return {&light_field.CameraOf(*view), &view->cam_from_world, seen.in_img};
}

double ReprojectionErrorPx(const PosedObservation& observation, const Vector3d& point_in_world) {
  const auto img = observation.camera->ImgFromCam(*observation.cam_from_world * point_in_world);
  return img ? (*img - observation.in_img).norm() : std::numeric_limits<double>::infinity();
}

}  // namespace ulf
