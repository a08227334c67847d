// Pixels at which a sensor was full, or the numbers of a file were: of the light there only a lower bound is
// known.
//
// What comes after the sensor hides it: a demosaicing mixes full pixels with others, white balance, colour
// matrix and flat field move full scale. Therefore these pixels are looked for in what the camera gave, and
// kept beside the light that is made of it.
#pragma once

#include <opencv2/core.hpp>

#include "core/image/image.h"

namespace ulf {

// From this share of full scale on a number counts as full, as encoded: lossy files have full areas a level
// lower here and there.
inline constexpr double kClippedFrom = 254.0 / 255;

// CV_8UC3, 255 where a colour is full, from this share of full scale on, as encoded. Of a mosaic also around
// the pixels that are, as far as Demosaiced() takes them into the same colour of others; it takes none into
// another colour. Empty where nothing is full, and for float pixels, which have no full scale.
cv::Mat ClippedColors(const Image& image, double from = kClippedFrom);

// The same for pixels: CV_8UC1, 255 where any colour is full.
cv::Mat ClippedPixels(const Image& image);

// Around the pixels of a mosaic that are marked, as far as demosaicing takes them in; each channel by itself.
// Empty where none is.
cv::Mat ClippedAfterDemosaicing(const cv::Mat& clipped);

// Masks of pixels (CV_8UC1) and of their colours (CV_8UC3): marked where any colour is; all colours marked
// where a pixel is.
cv::Mat AnyColor(const cv::Mat& mask);
cv::Mat InThreeColors(const cv::Mat& one);

}  // namespace ulf
