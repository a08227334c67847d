// Merges photographs of one view at several exposures to one picture of linear light, which reaches from the
// darkest that the longest exposure tells to the brightest that the shortest one does.
//
// The light at a pixel is the mean of the exposures, each over its ratio to the reference, weighed by one
// over the variance (Hasinoff, Durand and Freeman 2010, "Noise-optimal capture for high dynamic range
// photography"). The variance is shot noise and read noise at the merged light: at the noisy number itself it
// would favour numbers that are too low. A clipped colour of a pixel has no weight; its other colours do,
// where the picture does not mix them.
//
// An exposure that may be misaligned or blurred by so many pixels is less sure where the light changes: it
// makes flat parts less noisy and leaves edges to the others. What disagrees with the reference by more than
// all that (a ghost) is left out there (exposure_ghosts.h).
//
// Light is a share of the exposure's full scale, above black; B G R in memory.
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
  double black_level = 0;  // as in Frame
  double gain = 1;
  // Whether each colour is made of several of the sensor's (a colour matrix, a demosaicing that looks at all
  // colours): then none is known where one is full. Demosaiced() does not.
  bool mixes_colors = false;
};

// Of photographs by one sensor. Their noise is measured in all of them that have the same gain.
std::vector<ExposedLight> ExposedLightsOf(std::span<const SensorPicture> pictures);

// The exposure's light over the reference's for the same light, where both tell it: means of small blocks, so
// that noise and misalignment hardly count. 0: it is not known to half a per cent.
double MeasuredRatio(const AlignedExposure& exposure, const AlignedExposure& reference);

struct MergedLight {
  cv::Mat light;    // CV_32FC3, in shares of the reference's full scale: above 1 where only others tell it
  cv::Mat clipped;  // CV_8UC1, 255 where no exposure tells the light of some colour: a lower bound
  cv::Mat ghosts;   // CV_8UC1, 255 where an exposure is left out because it disagrees (exposure_ghosts.h)
  double ghost_share = 0;  // of all pixels
};

// The first exposure is the reference; all have one size.
MergedLight MergeExposures(std::span<const AlignedExposure> exposures);

}  // namespace ulf
