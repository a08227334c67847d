// Represents what a frame shows of a given world: corners of a board or of markers at known positions.
//
// The corners take part wherever the map's points do: in the frame's pose, and as known points in the bundle
// adjustment of the keyframes that saw them. So a map that has been moved into their world
// (Tracker::MoveWorld) is metric, and adjustments leave it where the board is.
#pragma once

#include <vector>

#include "core/geometry/rigid3.h"
#include "tracking/estimation/absolute_pose.h"

namespace ulf::tracking {

struct FiducialObservation {
  // Image points are where the sensor saw the corners, sigmas large enough to count these as independent.
  std::vector<PointObservation> corners;
  Rigid3 cam_from_world;    // from the corners alone
  double center_sigma = 0;  // one standard deviation of that pose's centre, world units; 0: it is not certain
};

// Converts the observation to an image resized by `scale`.
inline FiducialObservation Scaled(FiducialObservation fiducials, const Eigen::Vector2d& scale) {
  for (PointObservation& corner : fiducials.corners) {
    corner.img = corner.img.cwiseProduct(scale);
    corner.sigma_px *= scale.mean();
  }
  return fiducials;
}

}  // namespace ulf::tracking
