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

// Computes the positions of all points observed by these views again; removes points that cannot be
// triangulated.
void FitPointsOf(const std::set<int>& view_ids, LightField& light_field);

// Removes observations of missing views and those with larger errors than kMostTrackErrorPx, and sets every
// point's error. A track of one observation is removed too; the point stays. Returns how many errors were
// larger.
std::size_t MeasurePoints(LightField& light_field);

// Statistics of all points.
struct PointStatistics {
  std::size_t points = 0, tracked = 0, observations = 0;
  double mean_track_length = 0;  // of points with a track
  double mean_error_px = 0;      // px, of all observations
};
PointStatistics StatisticsOf(const std::vector<ScenePoint>& points);

// Triangulates a point from observations with known poses by minimising reprojection errors. Image points are
// in pixels, positions in world units.

struct PosedObservation {
  const CameraModel* camera = nullptr;
  const Rigid3* cam_from_world = nullptr;
  Eigen::Vector2d in_img = Eigen::Vector2d::Zero();
};

// Has no camera if there is no such view.
PosedObservation PosedObservationOf(const ViewObservation& seen, const LightField& light_field);

// Starts at the point nearest to all rays and minimises Huber's loss with a threshold of one pixel. Returns
// none if fewer than two cameras have the point in front of them, or the rays are nearly parallel.
std::optional<Eigen::Vector3d> FitPoint(std::span<const PosedObservation> observations);

// Returns an observation's distance from the point's projection in pixels; infinite if it has none.
double ReprojectionErrorPx(const PosedObservation& observation, const Eigen::Vector3d& point_in_world);

}  // namespace ulf
