// Whether rows are read one after the other, and how fast: found out from the map's keyframes.
//
// Under a rolling shutter what is seen misses its place by its row's time times its velocity in the image.
// Linearised about the adjusted map, with every pose and point free (else they would already have taken up
// most of it), the readout time is one more unknown of a least squares problem. A lens that is not quite as
// calibrated shears and stretches the image in the same way for as long as the camera moves in one direction:
// both are unknowns too, common to all keyframes, so that only motion in several directions tells. What the
// keyframes say apart from each other tells how certain it is (sandwich estimate, one cluster a keyframe).
#pragma once

#include <optional>

#include "core/geometry/camera_model.h"
#include "tracking/map/map.h"

namespace ulf::tracking {

// From the newest keyframes whose velocity is known. None where there are too few, or where their motion
// does not tell.
std::optional<ReadoutEstimate> EstimateReadout(const CameraModel& camera, const Map& map);

}  // namespace ulf::tracking
