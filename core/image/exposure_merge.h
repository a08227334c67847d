// Merges photographs of one view at several exposures to one picture of linear light, which reaches from the darkest
// that the longest exposure tells to the brightest that the shortest one does.
//
// The light at a pixel is the mean of the exposures, each over its ratio to the reference, weighed by one over the
// variance (Hasinoff, Durand and Freeman 2010, "Noise-optimal capture for high dynamic range photography"). The variance
// is shot noise and read noise at the merged light: at the noisy number itself it would favour numbers that are too low.
// A clipped pixel has no weight.
//
// Where exposures differ by more than their noise, something moved, or the alignment is wrong there (a ghost): the pixel
// keeps the reference exposure alone, or where this is clipped the one next to it. Allowed for: half a pixel of wrong
// alignment, two per cent between the exposures' times as told and as they are, and noise that the alignment has made
// larger than it was measured (a factor common to all pixels).
//
// Light is a share of the exposure's full scale, above black; B G R in memory.
#pragma once

#include <opencv2/core.hpp>
#include <span>

#include "core/image/image.h"

namespace ulf {

// The variance of a photograph's light: per_light * light + floor.
struct SensorNoise {
  double per_light = 0;  // shot noise: gain over the full well
  double floor = 0;      // read noise and rounding
  double VarianceAt(double light) const { return per_light * (light > 0 ? light : 0) + floor; }
};

// A photograph as light, with what a merge has to know of it.
struct ExposedLight {
  cv::Mat light;    // CV_32FC3
  cv::Mat clipped;  // CV_8UC1, 255: only a lower bound is known, or noise was cut off at full scale
  SensorNoise noise;
};

// Measures the noise on what is smooth in the picture. `black_level` as in Frame.
ExposedLight ExposedLightOf(const Image& image, double black_level);

// In the reference's pixels (exposure_alignment.h).
struct AlignedExposure {
  cv::Mat light;    // CV_32FC3
  cv::Mat seen;     // CV_8UC1, 255 where the exposure shows what the reference's pixel shows
  cv::Mat clipped;  // CV_8UC1
  SensorNoise noise;
  double ratio = 1;  // exposure time times gain, over the reference's
};

// The exposure's light over the reference's for the same light, where both tell it well; 0: too few pixels do.
double MeasuredRatio(const AlignedExposure& exposure, const AlignedExposure& reference);

struct MergedLight {
  cv::Mat light;    // CV_32FC3, in shares of the reference's full scale: above 1 where only others tell it
  cv::Mat clipped;  // CV_8UC1, 255 where no exposure tells the light: a lower bound
  cv::Mat ghosts;   // CV_8UC1, 255 where one exposure stands alone because they disagree
  double ghost_share = 0;  // of all pixels
};

// The first exposure is the reference; all have one size.
MergedLight MergeExposures(std::span<const AlignedExposure> exposures);

}  // namespace ulf
