// Converts what a TIFF (6.0) stores to pixels: samples of any number of bits, palettes, transfer functions.
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
// `samples` from the column `x` and the channel `first_channel` on. The depth of `samples` is CV_8U for
// integers of up to 8 bits, CV_16U for larger ones, CV_32F for floating point; full scale stays full scale.
void CopyTiffRow(const TiffNumbers& numbers, const std::uint8_t* row, int count, int block_channels, int x,
                 int y, int first_channel, cv::Mat& samples);

// Returns the first `count` channels, without alpha and other extra samples.
cv::Mat FirstChannels(const cv::Mat& samples, int count);

// Returns the colours (CV_8UC3) of indices (CV_8UC1) into a palette of `count` reds, greens and blues;
// palettes have 16 bits, but a few programs write 8, in which no entry is above 255.
cv::Mat ThroughPalette(const cv::Mat& indices, const std::array<const std::uint16_t*, 3>& rgb, int count);

// Converts pixels of 8 or 16 bits to sRGB by the tag TransferFunction, which lists for every number its
// light, 0 to 65535: for red, green and blue, or for all if the others are null. Returns false, and leaves
// the pixels, if they are nearly sRGB already.
bool ApplyTransferFunction(const std::array<const std::uint16_t*, 3>& rgb, cv::Mat& pixels);

// Warns if the tag MaxSampleValue, `largest`, needs fewer bits than the file's samples have, unless `samples`
// (as CopyTiffRow() gives them) are above it.
void WarnOfUnusedBits(unsigned largest, int bits, const cv::Mat& samples, StoredPicture& picture);

// Undoes premultiplication by `alpha`, one channel of the depth of `pixels`.
void DivideByAlpha(const cv::Mat& alpha, cv::Mat& pixels);

}  // namespace ulf
