// The numbers of a TIFF (TIFF 6.0): samples of any size, palettes and transfer functions.
#pragma once

#include <array>
#include <cstdint>
#include <opencv2/core.hpp>

#include "core/image/files/stored_picture.h"

namespace ulf {

struct TiffNumbers {
  int bits = 8;
  bool is_float = false;  // of 16, 24, 32 or 64 bits; else whole numbers of 1 to 16 or of 32
  bool is_index = false;  // into a palette: whole numbers are not spread to full scale
};

// `count` pixels of `block_channels` samples, one after the other in `row`, to the row `y` of `samples` from
// the column `x` and the channel `first_channel` on. Whole numbers become CV_8U or CV_16U, floating point
// CV_32F, which `samples` is made of.
void CopyTiffRow(const TiffNumbers& numbers, const std::uint8_t* row, int count, int block_channels, int x,
                 int y, int first_channel, cv::Mat& samples);

cv::Mat FirstChannels(const cv::Mat& samples, int count);

// CV_8UC3 of indices (CV_8UC1). Red, green and blue of `count` colours; palettes have 16 bits, but a few
// programs write 8, in which no entry is above 255.
cv::Mat ThroughPalette(const cv::Mat& indices, const std::array<const std::uint16_t*, 3>& rgb, int count);

// Replaces numbers of 8 or 16 bits by those of sRGB, by the light, of 65535, of every number: of red, green
// and blue, or of the first for all where the others are null. False where that is nearly sRGB itself: the
// pixels stay.
bool ApplyTransferFunction(const std::array<const std::uint16_t*, 3>& rgb, cv::Mat& pixels);

// Warns where the largest number that a file tells of (MaxSampleValue) is that of fewer bits than it has,
// unless samples, as CopyTiffRow() gives them, are above it.
void WarnOfUnusedBits(unsigned largest, int bits, const cv::Mat& samples, StoredPicture& picture);

// Colours that were multiplied by `alpha`, which has their depth.
void DivideByAlpha(const cv::Mat& alpha, cv::Mat& pixels);

}  // namespace ulf
