// Fits a camera model of ours to a lens that another program describes by another formula.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>

#include "core/geometry/camera_model.h"

namespace ulf {

struct CameraFit {
  CameraModel camera;
  double rms_px = 0;      // over the image
  double largest_px = 0;  // the largest distance that a pixel moves
};

// Returns the image point in px of a point of the camera frame; none where the lens shows nothing.
using Projection = std::function<std::optional<Eigen::Vector2d>(const Eigen::Vector3d& point_in_cam)>;

// Fits focal lengths, principal point and the coefficients of the kind of `start` (kNone: none) by least
// squares over the rays that `project` images, on a grid that `start` lays over the picture and half as much
// around it. `start` gives size and first values; keep it close. If no step improves on `start`, it is
// returned with its own distances.
CameraFit FitCamera(const Projection& project, const CameraModel& start);

// Measures a camera against the lens as FitCamera() does, without changing it.
CameraFit CompareCamera(const Projection& project, const CameraModel& camera);

}  // namespace ulf
