// What a frame shows of a world that is given: corners of a board or of markers, whose places are known.
//
// They take part wherever the map's points do: in the frame's pose, and as known points in the bundle
// adjustment of the keyframes that saw them. A map that has been moved into their world (Tracker::MoveWorld)
// is thereby metric, and held where the board is however long it is adjusted.
#pragma once

#include <vector>

#include "core/geometry/rigid3.h"
#include "tracking/estimation/absolute_pose.h"

namespace ulf::tracking {

struct FiducialObservation {
  // As the sensor saw them; the sigmas are such that the corners may be taken for independent.
  std::vector<PointObservation> corners;
  Rigid3 cam_from_world;    // as they alone have it
  double center_sigma = 0;  // of that pose, world units; 0: they alone are not sure of it
};

}  // namespace ulf::tracking
