// Writes a picture as an uncompressed TIFF file, the format of masters and recorded frames. Compressing 16
// bits takes ten times as long as writing them, and a library's encoder copies the picture twice; this writer
// copies no pixels. The file has one little-endian strip, the baseline tags of TIFF 6.0, and SampleFormat.
#pragma once

#include <opencv2/core.hpp>

#include "core/base/atomic_file.h"

namespace ulf {

// Returns the file for `pixels`: 8 or 16 bits or float, one channel, or three in the order B, G, R (stored as
// R, G, B). The pixels are shared, not copied. Throws Error for another type, or for more than 4 GB.
FileContent TiffContent(const cv::Mat& pixels);

// Returns the pixels of `bytes` that TiffContent() wrote for a picture of one channel and this size and type;
// empty for any other bytes. It allocates no more than the picture asked for, whatever the bytes claim.
cv::Mat PixelsOfTiff(std::string_view bytes, const cv::Size& size, int type);

}  // namespace ulf
