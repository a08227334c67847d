// A simulated sensor's numbers as the bytes that a machine-vision camera sends: what pixel_format.h takes
// apart, put together.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>

#include "core/image/pixel_format.h"

namespace ulf::acquisition {

// The part of the picture in rows without padding. `pixels` is as an ulf::Image holds it: 8 bits, or 16 with
// the format's bits spread; three channels are B, G, R. `out` has room for ImageBytes() of the part.
void PackImage(const cv::Mat& pixels, const cv::Rect& part, const PixelFormat& format, std::uint8_t* out);

}  // namespace ulf::acquisition
