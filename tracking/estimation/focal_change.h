// Measures by how much a frame's focal length differs from that of its map: a zoom that was moved while the
// camera was followed, or a lens that refocused and breathed.
//
// One frame's points tell it where they lie at different depths: moving forward magnifies what is near more
// than what is far, another focal length magnifies all alike. So the focal length is freed beside the pose,
// with the map's points held. A lens that was wrong from the start has bent the map, and shows hardly
// anything here (calibration_check.h).
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

// `observations` under `cam_from_world`, which is refined beside the focal length. Returns none where fewer
// than 30 points are given, or where their depths do not tell it.
std::optional<FocalChange> MeasureFocalChange(const CameraModel& camera,
                                              std::span<const PointObservation> observations,
                                              const Rigid3& cam_from_world);

}  // namespace ulf::tracking
