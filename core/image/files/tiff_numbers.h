// Converts the samples of a TIFF (TIFF 6.0) of any size, palettes and transfer functions.
#pragma once

#include <array>
#include <cstdint>
#include <opencv2/core.hpp>

#include "core/image/files/stored_picture.h"

namespace ulf {

struct TiffNumbers {
  int bits = 8;
  bool is_float = false;  // 16, 24, 32 or 64 bits; otherwise integers of 1 to 16 or of 32
  bool is_index = false;  // index into a palette: integers are not spread to full scale
};

// Copies `count` pixels of `block_channels` samples, one after the other in `row`, to the row `y` of
// `samples` from the column `x` and the channel `first_channel` on. Integers become CV_8U or CV_16U, floating
// point CV_32F, the type of `samples`.
void CopyTiffRow(const TiffNumbers& numbers, const std::uint8_t* row, int count, int block_channels, int x,
                 int y, int first_channel, cv::Mat& samples);

cv::Mat FirstChannels(const cv::Mat& samples, int count);

// Returns the colours (CV_8UC3) of indices (CV_8UC1) into a palette of `count` reds, greens and blues;
// palettes have 16 bits, but a few programs write 8, in which no entry is above 255.
cv::Mat ThroughPalette(const cv::Mat& indices, const std::array<const std::uint16_t*, 3>& rgb, int count);

// Converts 8 or 16 bits to sRGB by a table of the light (of 65535) of every number, for red, green and blue,
// or for all if the others are null. Returns false if the table is nearly sRGB; the pixels then stay.
bool ApplyTransferFunction(const std::array<const std::uint16_t*, 3>& rgb, cv::Mat& pixels);

// Warns if MaxSampleValue of the file needs fewer bits than its samples have, unless samples, as
// CopyTiffRow() gives them, are above it.
void WarnOfUnusedBits(unsigned largest, int bits, const cv::Mat& samples, StoredPicture& picture);

// Undoes premultiplication by `alpha`, which has the depth of `pixels`.
void DivideByAlpha(const cv::Mat& alpha, cv::Mat& pixels);

}  // namespace ulf
