// Measures a rolling shutter's readout time from the map's keyframes.
//
// Under a rolling shutter an observation is off by its row's time times its velocity in the image. Near the
// adjusted map this is linear: the readout time is one more unknown of a least squares problem in which every
// pose and point is free: they have absorbed most of it. A lens that is not quite as calibrated shears and
// stretches the image in the same way as long as the camera moves in one direction. So a shear and a stretch,
// common to all keyframes, are unknowns, too, and only motion in several directions determines the readout.
// The spread between keyframes gives the uncertainty (sandwich estimate, one cluster a keyframe).
#pragma once

#include <optional>

#include "core/geometry/camera_model.h"
#include "tracking/map/map.h"

namespace ulf::tracking {

// Uses the newest keyframes whose velocity is known. Returns none if they are fewer than `least_keyframes`
// (guessed), or if their motion does not determine the readout.
std::optional<ReadoutEstimate> EstimateReadout(const CameraModel& camera, const Map& map,
                                               int least_keyframes = 5);

}  // namespace ulf::tracking
