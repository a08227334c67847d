// Predicts how certain an adjustment's camera centres are, given the observations it kept.
//
// Computes the covariance of the cameras with points eliminated (Triggs et al. 2000, section 9), scaled to
// the observations' actual errors. Where fewer than two cameras are fixed and no point is known, the whole
// may move, turn and scale freely; then the result is the error that remains after the similarity that fits
// the centres best (Baarda's S-transformation). Takes the lenses for right. Dense: the work grows with the
// third power of the number of cameras.
#pragma once

#include <vector>

#include "core/geometry/camera_model.h"
#include "tracking/estimation/bundle_adjustment.h"

namespace ulf::tracking {

// Returns one standard deviation of every camera's centre, world units: 0 for a fixed one, infinite for all
// where something can move freely, NaN for a camera without observations.
std::vector<double> CenterSigmas(const std::vector<CameraModel>& lenses, const BundleProblem& problem);

}  // namespace ulf::tracking
