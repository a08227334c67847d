// Where exposures of a bracket differ by more than noise allows: something moved, or the alignment is wrong
// there.
//
// Each exposure is compared, colour by colour, with the one that counts alone: the reference, or where that
// is clipped the one next to it. A pixel is a ghost in all colours if it is in one. Differences are means
// over three by three pixels. Allowed for is noise (also what demosaicing and resampling have tied together
// in neighbours: a factor common to all pixels, measured), what the light changes by within
// AlignedExposure::misaligned_px, and two per cent between the exposures' times as told and as they are.
#pragma once

#include <opencv2/core.hpp>
#include <span>

#include "core/image/exposure_alignment.h"

namespace ulf {

struct LightAlone {
  cv::Mat which;     // CV_8UC3: the exposure that counts alone
  cv::Mat light;     // CV_32FC3: its, over its ratio
  cv::Mat variance;  // CV_32FC3: of that
  cv::Mat clipped;   // CV_8UC3, 255 where all are clipped that see the pixel: then it is the shortest of them
};
LightAlone AloneAt(std::span<const AlignedExposure> exposures);

// What the light changes by from pixel to pixel, at most in the pixels around: CV_32FC3. `variance`: of the
// light, whose part in the change is taken out; empty: none.
cv::Mat SlopeOf(const cv::Mat& light, const cv::Mat& variance = {});

// CV_8UC1, 255 where this exposure is not to be used. A clipped pixel disagrees where it says that there is
// more light.
cv::Mat GhostsIn(std::span<const AlignedExposure> exposures, std::size_t index, const LightAlone& alone);

}  // namespace ulf
