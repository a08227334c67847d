// Represents what a frame shows of a given world: corners of a board or of markers at known positions.
//
// After the map has been moved into that world (Tracker::MoveWorld), the corners take part wherever the map's
// points do: in the frame's pose, and as known points in the bundle adjustment of the keyframes that saw
// them. So the map is metric, and adjustments leave it where the board is.
#pragma once

#include <vector>

#include "core/geometry/rigid3.h"
#include "tracking/estimation/absolute_pose.h"

namespace ulf::tracking {

struct FiducialObservation {
  // Corners in the given world. Image points are where the sensor saw them; sigmas are so large that the
  // corners' errors may count as independent.
  std::vector<PointObservation> corners;
  Rigid3 cam_from_world;    // from the corners alone
  double center_sigma = 0;  // one standard deviation of that pose's centre, world units; 0: it is not certain
};

// Converts the observation to an image that is resized by `scale` (x, y).
inline FiducialObservation Scaled(FiducialObservation fiducials, const Eigen::Vector2d& scale) {
  for (PointObservation& corner : fiducials.corners) {
    corner.img = corner.img.cwiseProduct(scale);
    corner.sigma_px *= scale.mean();
  }
  return fiducials;
}

}  // namespace ulf::tracking
