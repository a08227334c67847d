#include "core/image/files/stored_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cctype>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <opencv2/imgproc.hpp>

namespace ulf {

void TakePixels(const cv::Mat& pixels, StoredPicture& picture) {
  const int colors = pixels.channels() < 3 ? 1 : 3;
  picture.pixels = pixels;
  if (pixels.channels() == colors) return;
  cv::extractChannel(pixels, picture.alpha, colors);
  if (colors == 1)
    cv::extractChannel(pixels, picture.pixels, 0);
  else
    cv::cvtColor(pixels, picture.pixels, cv::COLOR_BGRA2BGR);
}

std::string WithoutNumbers(const std::string& sentence) {
  std::string words;
  bool is_in_number = false;
  for (char before = ' '; const char c : sentence) {
    const auto is = [](int (*kind)(int), char of) { return kind(static_cast<unsigned char>(of)) != 0; };
    if (is(std::isdigit, c) && !is(std::isalnum, before)) is_in_number = true;
    if (is(std::isspace, c) || c == ',' || c == ')' || c == ';') is_in_number = false;
    if (!is_in_number) words += c;
    before = c;
  }
  return words;
}

void NoteOrientation(int orientation, StoredPicture& picture) {
  constexpr std::array kWords = {"mirrored",
                                 "turned by 180 degrees",
                                 "turned by 180 degrees and mirrored",
                                 "turned by 90 degrees and mirrored",
                                 "turned by 90 degrees clockwise",
                                 "turned by 90 degrees clockwise and mirrored",
                                 "turned by 90 degrees counterclockwise"};
  constexpr int kFirst = 2;
  if (orientation < kFirst || orientation >= kFirst + static_cast<int>(kWords.size())) return;
  picture.notes.push_back(
      {fmt::format("its mark says that it is shown {}",
                   kWords[static_cast<std::size_t>(orientation - kFirst)]),
       ": its pixels stay in the order of the file, for which the camera's calibration holds",
       PictureNote::Kind::kTagged});
}

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

// Visits all channels of every `step`th pixel.
template <typename Look>
void LookAtNumbers(const cv::Mat& pixels, std::size_t step, const Look& look) {
  const auto columns = static_cast<std::size_t>(pixels.cols);
  for (std::size_t at = 0; at < pixels.total(); at += step) {
    const float* pixel = pixels.ptr<float>(static_cast<int>(at / columns), static_cast<int>(at % columns));
    for (int c = 0; c < pixels.channels(); ++c) look(pixel[c]);
  }
}

// Returns the median of the numbers above 0, by some of the pixels; 0 if fewer than a hundredth are: lamps in
// the dark.
float MedianOfLit(const cv::Mat& pixels) {
  constexpr std::size_t kLookedAt = 300'000, kFewest = 100;
  std::size_t all = 0;
  std::vector<float> lit;
  LookAtNumbers(pixels, (pixels.total() / kLookedAt) | 1, [&](float number) {
    ++all;
    if (number > 0 && IsFiniteNumber(number)) lit.push_back(number);
  });
  if (lit.empty() || lit.size() * kFewest < all) return 0;
  const auto middle = lit.begin() + static_cast<std::ptrdiff_t>((lit.size() - 1) / 2);
  std::ranges::nth_element(lit, middle);
  return *middle;
}

}  // namespace

void CheckFloatNumbers(StoredPicture& picture) {
  if (picture.pixels.depth() != CV_32F) return;
  const cv::Mat& pixels = picture.pixels;
  if (const std::size_t count = CountNotFinite(pixels); count > 0) {
    std::size_t nan = 0;
    LookAtNumbers(pixels, 1, [&](float number) { nan += std::isnan(number); });
    picture.warnings.push_back(
        fmt::format("it holds numbers that say no light ({} NaN, {} infinite): such pixels get no weight in "
                    "renderings, and are black or white in copies of 8 bits",
                    nan, count - nan));
  }
  const float median = MedianOfLit(pixels);
  if (!(median > 1)) return;
  float largest = 0;
  LookAtNumbers(pixels, 1, [&](float number) {
    if (IsFiniteNumber(number)) largest = std::max(largest, number);
  });
  constexpr float kFewestLevels = 255, kMostLevels = 65535;
  const unsigned levels =
      std::bit_ceil(static_cast<unsigned>(std::clamp(std::ceil(largest), kFewestLevels, kMostLevels)) + 1) -
      1;
  picture.warnings.push_back(fmt::format(
      "more than half of its light is brighter than 1, which is white in floating point (median {:g}, "
      "largest {:g}): it is taken as it is; divide {}absolute light by the number of its white",
      median, largest,
      largest > kMostLevels ? ""
                            : fmt::format("levels of {} bits by {}, and ", std::bit_width(levels), levels)));
}

}  // namespace ulf
