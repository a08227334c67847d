// A picture as an uncompressed TIFF file: what masters and recorded frames are kept in. Compressing 16 bits
// takes ten times as long as writing them, and a library's encoder copies the picture twice on its way; here
// the pixels go from where they are to the disk. One strip, little-endian, baseline tags of TIFF 6.0 (and its
// SampleFormat), so that every reader opens it.
#pragma once

#include <opencv2/core.hpp>

#include "core/base/atomic_file.h"

namespace ulf {

// The file for `pixels`: 8 or 16 bits or float, one channel, or three in the order B, G, R (stored as R, G,
// B). The pixels are shared, not copied. Throws Error for another type, or for more than 4 GB.
FileContent TiffContent(const cv::Mat& pixels);

}  // namespace ulf
