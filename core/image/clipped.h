// Finds clipped pixels: the sensor or the number range of the file was full, and the light may be more.
//
// Later steps hide clipping: demosaicing mixes full pixels with others, and white balance, colour matrix and
// flat field move full scale. Therefore clipped pixels are found in what the camera gave, and a mask of them
// is kept beside the light made of it.
#pragma once

#include <opencv2/core.hpp>

#include "core/image/image.h"

namespace ulf {

// Encoded values count as full from this share of full scale on: lossy files vary by a level in full areas.
inline constexpr double kClippedFrom = 254.0 / 255;

// Returns a mask of colours: CV_8UC3, 255 where the encoded value is at least the share `from` of full scale.
// In a mosaic it also marks that colour of the pixels around, because Demosaiced() computes it, and no other
// colour, from the full value. Empty if nothing is full, and for float pixels, which have no full scale.
cv::Mat ClippedColors(const Image& image, double from = kClippedFrom);

// Returns the same as a mask of pixels: CV_8UC1, 255 if any colour is marked.
cv::Mat ClippedPixels(const Image& image);

// Returns a mask of demosaiced pixels, or colours, that also marks the neighbours which demosaicing computes
// from marked ones, each channel by itself. Empty if none is marked.
cv::Mat ClippedAfterDemosaicing(const cv::Mat& clipped);

// AnyColor() makes a mask of pixels (CV_8UC1) from one of colours (CV_8UC3): a pixel is marked if one of its
// colours is. InThreeColors() makes a mask of colours: all three are marked if their pixel is.
cv::Mat AnyColor(const cv::Mat& mask);
cv::Mat InThreeColors(const cv::Mat& one);

}  // namespace ulf
