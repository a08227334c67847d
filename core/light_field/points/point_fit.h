// Triangulates a point from observations with known poses by minimising reprojection errors. Image points are
// in pixels, positions in world units.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

#include "core/geometry/camera_model.h"
#include "core/geometry/rigid3.h"

namespace ulf {

struct PosedObservation {
  const CameraModel* camera = nullptr;
  const Rigid3* cam_from_world = nullptr;
  Eigen::Vector2d in_img = Eigen::Vector2d::Zero();
};

// Starts at the point nearest to all rays and minimises Huber's loss with a threshold of one pixel. None:
// fewer than two cameras have the point in front of them, or the rays are nearly parallel.
std::optional<Eigen::Vector3d> FitPoint(std::span<const PosedObservation> observations);

// Distance of an observation from the point's projection in pixels; infinite when it has none.
double ReprojectionErrorPx(const PosedObservation& observation, const Eigen::Vector3d& point_in_world);

}  // namespace ulf
