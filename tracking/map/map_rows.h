// Compensates a rolling shutter in a map that was made without.
#pragma once

#include "core/geometry/camera_model.h"
#include "tracking/map/map.h"

namespace ulf::tracking {

// Gives every keyframe with a known velocity rows of this readout (0: none), and moves its observations. The
// caller holds the map's lock.
void GiveRows(const CameraModel& camera, Map& map, double readout_s);

}  // namespace ulf::tracking
