// Finds ghosts: pixels at which exposures of a bracket differ by more than noise allows, because something
// moved or the alignment is wrong.
//
// Each exposure is compared, colour by colour, with a single other one: the reference, or where that is
// clipped the exposure nearest to it in brightness that is not. A pixel is a ghost in all colours if it is in
// one. Differences are means over three by three pixels. The tolerance covers noise (with a measured factor,
// common to all pixels, for correlation by demosaicing and resampling), the change of light within
// AlignedExposure::misaligned_px, and two per cent of error of the stated exposure times.
#pragma once

#include <opencv2/core.hpp>
#include <span>

#include "core/image/exposure_alignment.h"

namespace ulf {

// The exposure that each colour of a pixel is compared with.
struct GhostReference {
  cv::Mat which;     // CV_8UC3: index of the exposure
  cv::Mat light;     // CV_32FC3: its light, divided by its ratio
  cv::Mat variance;  // CV_32FC3: the variance of that light
  cv::Mat clipped;   // CV_8UC3, 255 where all exposures that see the pixel are clipped; the shortest is used
};
// The first exposure is the reference of all; there are at most 256, of one size.
GhostReference GhostReferenceOf(std::span<const AlignedExposure> exposures);

// Returns the largest change of light from pixel to pixel in the neighbourhood, CV_32FC3, less what noise of
// this `variance` contributes; empty means no noise.
cv::Mat SlopeOf(const cv::Mat& light, const cv::Mat& variance = {});

// Returns CV_8UC1, 255 where exposure `index` disagrees with the reference and must not be used. A clipped
// pixel, a lower bound, disagrees only if it is brighter.
cv::Mat GhostsIn(std::span<const AlignedExposure> exposures, std::size_t index, const GhostReference& alone);

}  // namespace ulf
