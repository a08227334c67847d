// Merges photographs of one view at several exposures to one picture of linear light, from the darkest that
// the longest exposure resolves to the brightest that the shortest one does.
//
// The light at a pixel is the mean of the exposures, each divided by its ratio to the reference, with weights
// of one over the variance (Hasinoff, Durand and Freeman 2010, "Noise-optimal capture for high dynamic range
// photography"). The variance is that of shot noise and read noise at the merged light; at the noisy value
// itself it would favour values that are too low. A clipped colour of a pixel has no weight; its other
// colours do, unless the picture mixes colours.
//
// An exposure that may be misaligned or blurred is less certain at edges: it reduces the noise of flat areas
// and leaves edges to the others. Pixels that still disagree are left out (exposure_ghosts.h).
//
// Light is a share of the exposure's full scale, 0 at the black level. Channels are B G R in memory.
#pragma once

#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "core/image/exposure_alignment.h"
#include "core/image/image.h"
#include "core/image/sensor_noise.h"

namespace ulf {

struct SensorPicture {
  Image image;
  double black_level = 0;  // a share of full scale
  double gain = 1;         // as a factor
  // Each colour is computed from several of the sensor's (a colour matrix, a demosaicing across
  // colours): then one clipped colour makes all unknown. Demosaiced() does not mix them.
  bool mixes_colors = false;
};

// Converts photographs by one sensor. Noise is measured in all those of one gain together. Throws Error for a
// black level that is not at least 0 and below 1.
std::vector<ExposedLight> ExposedLightsOf(std::span<const SensorPicture> pictures);

// Returns the exposure's light divided by the reference's where both are unclipped, from means of small
// blocks, so that noise and misalignment hardly count; 0 if that cannot be told to half a per cent.
double MeasuredRatio(const AlignedExposure& exposure, const AlignedExposure& reference);

struct MergedLight {
  cv::Mat light;    // CV_32FC3, shares of the reference's full scale: above 1 where the reference is clipped
  cv::Mat clipped;  // CV_8UC1, 255 where all exposures are clipped in some colour: a lower bound
  cv::Mat ghosts;   // CV_8UC1, 255 where an exposure is left out because it disagrees (exposure_ghosts.h)
  double ghost_share = 0;  // of all pixels
};

// The first exposure is the reference; there are 1 to 255, of one size.
MergedLight MergeExposures(std::span<const AlignedExposure> exposures);

}  // namespace ulf
