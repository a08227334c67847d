// How far away things are: what is worth sweeping over.
#pragma once

#include <vector>

#include "render/stereo/plane_sweep.h"

namespace ulf::render {

// The sweep's range for a view, from one at half the size over everything from a fifth of the subject's
// distance to the horizon; planes so close that the neighbour that moves the most moves about a pixel from
// one to the next.
InverseDepthRange FindRange(const StereoView& view, const std::vector<const StereoView*>& neighbours,
                            double subject_distance);

// From `nearest` to `farthest`, planes a pixel apart for the widest neighbour.
InverseDepthRange PixelSpacedRange(const StereoView& view, const std::vector<const StereoView*>& neighbours,
                                   double nearest, double farthest);

// How much deeper a thing at this distance is that lies a pixel farther on in the neighbour that moves the
// most; infinite where none moves.
double DepthStepOfPixel(const StereoView& view, const std::vector<const StereoView*>& neighbours,
                        double distance);

}  // namespace ulf::render
