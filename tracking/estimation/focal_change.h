// Measures by how much a frame's focal length differs from the map's: a zoom was moved while the camera was
// followed, or the lens refocused and breathed.
//
// The points of one frame tell it if they lie at different depths: moving forward magnifies what is near more
// than what is far, another focal length magnifies all alike. So the focal length is freed beside the pose,
// with the map's points held. A lens that was wrong from the start has bent the map, and shows hardly
// anything here (calibration_check.h does).
#pragma once

#include <optional>
#include <span>

#include "core/geometry/camera_model.h"
#include "core/geometry/rigid3.h"
#include "tracking/estimation/absolute_pose.h"

namespace ulf::tracking {

struct FocalChange {
  double log_ratio = 0;  // of the frame's focal length over the camera's: 0.1 is 10.5 % more
  double sigma = 0;      // one standard deviation, from the residuals
};

// `cam_from_world` is the frame's pose under `camera`, whose focal length is the map's. Returns none with
// fewer than 30 observations, or if the equations are singular; `sigma` is large if depths hardly tell it.
std::optional<FocalChange> MeasureFocalChange(const CameraModel& camera,
                                              std::span<const PointObservation> observations,
                                              const Rigid3& cam_from_world);

}  // namespace ulf::tracking
