#include "core/image/files/float_numbers.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace ulf {
namespace {

bool IsFiniteNumber(float number) {
  constexpr std::uint32_t kExponent = 0x7F800000;
  return (std::bit_cast<std::uint32_t>(number) & kExponent) != kExponent;
}

std::size_t CountNotFinite(const cv::Mat& pixels) {
  std::size_t count = 0;
  for (int y = 0; y < pixels.rows; ++y) {
    const float* row = pixels.ptr<float>(y);
    unsigned in_row = 0;
    for (int i = 0; i < pixels.cols * pixels.channels(); ++i) in_row += IsFiniteNumber(row[i]) ? 0 : 1;
    count += in_row;
  }
  return count;
}

std::size_t CountNan(const cv::Mat& pixels) {
  std::size_t count = 0;
  for (int y = 0; y < pixels.rows; ++y)
    for (int i = 0; i < pixels.cols * pixels.channels(); ++i) count += std::isnan(pixels.ptr<float>(y)[i]);
  return count;
}

// Of the numbers above 0, by all channels of some of the pixels; 0 where fewer than a hundredth are: lamps in the dark.
float MedianOfLit(const cv::Mat& pixels) {
  constexpr std::size_t kLookedAt = 300'000, kFewest = 100;
  const std::size_t step = (pixels.total() / kLookedAt) | 1;
  const auto columns = static_cast<std::size_t>(pixels.cols),
             channels = static_cast<std::size_t>(pixels.channels());
  std::vector<float> lit;
  for (std::size_t at = 0; at < pixels.total(); at += step)
    for (std::size_t c = 0; c < channels; ++c)
      if (const float number = pixels.ptr<float>(static_cast<int>(at / columns))[at % columns * channels + c];
          number > 0 && IsFiniteNumber(number))
        lit.push_back(number);
  if (lit.empty() || lit.size() * kFewest * step < pixels.total() * channels) return 0;
  const auto middle = lit.begin() + static_cast<std::ptrdiff_t>((lit.size() - 1) / 2);
  std::ranges::nth_element(lit, middle);
  return *middle;
}

float LargestOf(const cv::Mat& pixels) {
  float largest = 0;
  for (int y = 0; y < pixels.rows; ++y)
    for (int i = 0; i < pixels.cols * pixels.channels(); ++i)
      if (const float number = pixels.ptr<float>(y)[i]; IsFiniteNumber(number))
        largest = std::max(largest, number);
  return largest;
}

}  // namespace

void CheckFloatNumbers(StoredPicture& picture) {
  if (picture.pixels.depth() != CV_32F) return;
  const cv::Mat& pixels = picture.pixels;
  if (const std::size_t count = CountNotFinite(pixels); count > 0) {
    const std::size_t nan = CountNan(pixels);
    picture.warnings.push_back(
        fmt::format("it holds numbers that say no light ({} NaN, {} infinite): such pixels get no weight in "
                    "renderings, and are black or white in copies of 8 bits",
                    nan, count - nan));
  }
  const float median = MedianOfLit(pixels);
  if (!(median > 1)) return;
  const float largest = LargestOf(pixels);
  constexpr float kMostOfLevels = 65535;
  constexpr unsigned kFewestLevels = 255;
  const unsigned full =
      largest > kMostOfLevels
          ? 0
          : std::bit_ceil(std::max(kFewestLevels, static_cast<unsigned>(std::ceil(largest))) + 1) - 1;
  picture.warnings.push_back(fmt::format(
      "more than half of its lit numbers are above 1, which is white in floating point (median {:g}, largest "
      "{:g}): they are taken as they are; divide {}absolute light by what its white has",
      median, largest,
      full == 0 ? "" : fmt::format("levels of {} bits by {}, and ", std::bit_width(full), full)));
}

}  // namespace ulf
