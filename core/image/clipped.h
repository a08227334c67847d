// Finds clipped pixels, at which a sensor or the number range of a file was full: only a lower bound of
// their light is known.
//
// Later steps hide clipping: a demosaicing mixes full pixels with others, and white balance, colour matrix
// and flat field move full scale. Therefore these pixels are found in what the camera gave, and kept beside
// the light made of it.
#pragma once

#include <opencv2/core.hpp>

#include "core/image/image.h"

namespace ulf {

// An encoded value counts as full from this share of full scale on: lossy files have full areas a level
// lower here and there.
inline constexpr double kClippedFrom = 254.0 / 255;

// Returns CV_8UC3, 255 at colours whose encoded value is at least this share of full scale. For a mosaic it
// marks also the pixels around them into whose same colour Demosaiced() mixes them; it mixes none into
// another colour. Empty if nothing is full, and for float pixels, which have no full scale.
cv::Mat ClippedColors(const Image& image, double from = kClippedFrom);

// Does the same for pixels: CV_8UC1, 255 if any colour is full.
cv::Mat ClippedPixels(const Image& image);

// Marks also the pixels of a mosaic into which demosaicing mixes marked ones, each channel by itself.
// Returns an empty image if none is marked.
cv::Mat ClippedAfterDemosaicing(const cv::Mat& clipped);

// Convert masks of colours (CV_8UC3) and of pixels (CV_8UC1): a pixel is marked if any of its colours is;
// all colours are marked if their pixel is.
cv::Mat AnyColor(const cv::Mat& mask);
cv::Mat InThreeColors(const cv::Mat& one);

}  // namespace ulf
