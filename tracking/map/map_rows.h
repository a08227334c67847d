// A map whose camera turns out to have a rolling shutter.
#pragma once

#include "core/geometry/camera_model.h"
#include "tracking/map/map.h"

namespace ulf::tracking {

// Every keyframe whose velocity is known gets rows of this readout (0: none), and its observations follow.
// The map's lock is held.
void GiveRows(const CameraModel& camera, Map& map, double readout_s);

}  // namespace ulf::tracking
