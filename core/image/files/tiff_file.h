// A picture as an uncompressed TIFF file, the format of masters and recorded frames. Compressing 16 bits
// takes ten times as long as writing them, and a library's encoder copies the picture twice; this writer
// copies no pixels. The file has one strip, is little-endian and uses the baseline tags of TIFF 6.0 and
// SampleFormat.
#pragma once

#include <opencv2/core.hpp>

#include "core/base/atomic_file.h"

namespace ulf {

// The file for `pixels`: 8 or 16 bits or float, one channel, or three in the order B, G, R (stored as R, G,
// B). The pixels are shared, not copied. Throws Error for another type, or for more than 4 GB.
FileContent TiffContent(const cv::Mat& pixels);

// The pixels of a file of TiffContent() for a picture of this size and type, of one channel; empty: the bytes
// are of another size, type or program. Takes no more memory than the picture that is asked for, whatever the
// bytes claim.
cv::Mat PixelsOfTiff(std::string_view bytes, const cv::Size& size, int type);

}  // namespace ulf
