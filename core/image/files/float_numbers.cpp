#include "core/image/files/float_numbers.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "core/base/counted.h"

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

// Whether nearly all numbers but zero are whole, and some above full scale: told by a million of them.
bool LooksLikeLevels(const cv::Mat& pixels) {
  constexpr std::size_t kLookedAt = 1'000'000;
  constexpr double kNearlyAll = 0.99;
  const auto in_row = static_cast<std::size_t>(pixels.cols) * static_cast<std::size_t>(pixels.channels());
  const std::size_t step =
      std::max<std::size_t>(1, in_row * static_cast<std::size_t>(pixels.rows) / kLookedAt) | 1;
  std::size_t lit = 0, whole = 0;
  float largest = 0;
  for (std::size_t at = 0; at < in_row * static_cast<std::size_t>(pixels.rows); at += step) {
    const float number = pixels.ptr<float>(static_cast<int>(at / in_row))[at % in_row];
    if (number == 0 || !IsFiniteNumber(number)) continue;
    ++lit;
    whole += number > 0 && number == std::floor(number);
    largest = std::max(largest, number);
  }
  return largest > 1 && static_cast<double>(whole) >= kNearlyAll * static_cast<double>(lit);
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
        fmt::format("it holds {} that say no light ({} NaN, {} infinite): such pixels get no weight in "
                    "renderings, and are black or white in copies of 8 bits",
                    Counted(count, "number"), nan, count - nan));
  }
  if (!LooksLikeLevels(pixels)) return;
  const float largest = LargestOf(pixels);
  constexpr float kMost8 = 255, kMost16 = 65535;
  const std::string as_levels =
      largest > kMost16
          ? std::string("divide them by what full scale is")
          : fmt::format("write levels of sRGB as whole numbers of {} bits, and divide levels of light by {}",
                        largest > kMost8 ? 16 : 8, largest > kMost8 ? kMost16 : kMost8);
  picture.warnings.push_back(fmt::format(
      "its numbers are whole, up to {:g}, as levels are, but are floating point, which is linear light with "
      "full scale at 1: they are taken for that; {}",
      largest, as_levels));
}

}  // namespace ulf
