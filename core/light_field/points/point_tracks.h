// Updates a light field's points for its poses. The observations (tracks) are measurements and stay;
// positions and errors are computed from them and the present poses.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <set>
#include <span>

#include "core/geometry/camera_model.h"
#include "core/geometry/rigid3.h"
#include "core/light_field/light_field.h"

namespace ulf {

// Observations with a larger reprojection error are removed, as in COLMAP's mapper (its default).
inline constexpr double kMostTrackErrorPx = 4;

// Computes anew all points that these views observe. Removes those for which FitPoint() returns none.
void FitPointsOf(const std::set<int>& view_ids, LightField& light_field);

// Removes observations of missing views and those with larger errors than kMostTrackErrorPx, and sets every
// point's error. A point with fewer than two observations left loses its track, and stays. Returns the number
// of larger errors.
std::size_t MeasurePoints(LightField& light_field);

// Statistics of all points.
struct PointStatistics {
  std::size_t points = 0, tracked = 0, observations = 0;  // tracked: points with a track
  double mean_track_length = 0;                           // of points with a track
  double mean_error_px = 0;                               // of all observations
};
PointStatistics StatisticsOf(const std::vector<ScenePoint>& points);

// An observation with its camera and pose, which must outlive it.
struct PosedObservation {
  const CameraModel* camera = nullptr;
  const Rigid3* cam_from_world = nullptr;
  Eigen::Vector2d in_img = Eigen::Vector2d::Zero();
};

// Returns an observation whose `camera` is null if there is no such view.
PosedObservation PosedObservationOf(const ViewObservation& seen, const LightField& light_field);

// Triangulates a point, in world coordinates: starts at the point nearest to all rays and minimises the
// reprojection errors under Huber's loss with a threshold of one pixel. Returns none if fewer than two
// cameras have the point in front of them, or the rays are nearly parallel.
std::optional<Eigen::Vector3d> FitPoint(std::span<const PosedObservation> observations);

// Returns an observation's distance from the point's projection in pixels; infinite if there is none.
double ReprojectionErrorPx(const PosedObservation& observation, const Eigen::Vector3d& point_in_world);

}  // namespace ulf
