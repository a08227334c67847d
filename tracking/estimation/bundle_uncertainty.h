// How sure an adjustment is of where its cameras are: what the observations it kept leave open.
//
// The covariance of the cameras, points eliminated (Triggs et al. 2000, section 9), for errors as large as
// the observations' really are. Where fewer than two cameras are fixed and no point is known the whole may be
// moved, turned and scaled freely: then it is the error that would remain after the similarity that fits the
// centres best (Baarda's S-transformation). Lenses are taken for right. Dense: of the third power of the
// number of cameras.
#pragma once

#include <vector>

#include "core/geometry/camera_model.h"
#include "tracking/estimation/bundle_adjustment.h"

namespace ulf::tracking {

// One standard deviation of every camera's centre, world units: 0 of a fixed one, infinite of all where
// something can move that no observation holds, not a number of a camera without observations.
std::vector<double> CenterSigmas(const std::vector<CameraModel>& lenses, const BundleProblem& problem);

}  // namespace ulf::tracking
