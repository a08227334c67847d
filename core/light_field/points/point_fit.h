// Where a point is by what pictures of known pose show: the place whose projections lie nearest to all its
// observations. Image quantities are pixels, positions world units.
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

// Begins at the place nearest to all rays; observations farther off than a pixel count less (Huber's loss).
// None where fewer than two pictures show it before them, or their rays are as good as parallel.
std::optional<Eigen::Vector3d> FitPoint(std::span<const PosedObservation> observations);

// Distance of an observation from the point's projection; infinite where it has none.
double ReprojectionErrorPx(const PosedObservation& observation, const Eigen::Vector3d& point_in_world);

}  // namespace ulf
