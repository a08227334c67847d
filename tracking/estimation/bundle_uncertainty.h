// Predicts how certain the camera centres of a bundle adjustment are, given the observations that it kept.
//
// The covariance of the cameras, with points eliminated (Triggs et al. 2000, section 9), is scaled to the
// observations' actual errors. If fewer than two cameras are fixed and no point is known, the whole may move,
// turn and scale freely; then the result is the error that remains after the similarity that fits the centres
// best (Baarda's S-transformation). Lenses are assumed to be right, shutters to be global. The work grows
// with the third power of the number of cameras.
#pragma once

#include <vector>

#include "core/geometry/camera_model.h"
#include "tracking/estimation/bundle_adjustment.h"

namespace ulf::tracking {

// Returns one standard deviation of every camera's centre, world units. Fixed cameras have 0 unless the whole
// may move, cameras without observations NaN, all others infinity if observations leave one open.
std::vector<double> CenterSigmas(const std::vector<CameraModel>& lenses, const BundleProblem& problem);

}  // namespace ulf::tracking
