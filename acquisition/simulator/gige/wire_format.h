// Packs the pixels of a simulated sensor as a machine-vision camera sends them: the inverse of unpacking by
// pixel_format.h.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>

#include "core/frames/pixel_format.h"

namespace ulf::acquisition {

// Writes a part of the image in rows without padding. `pixels`: as in ulf::Image, 8 bits or scaled to 16
// bits; three channels are B, G, R. `out`: room for ImageBytes() of the part.
void PackImage(const cv::Mat& pixels, const cv::Rect& part, const PixelFormat& format, std::uint8_t* out);

}  // namespace ulf::acquisition
