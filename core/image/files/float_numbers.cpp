#include "core/image/files/float_numbers.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "core/base/counted.h"

namespace ulf {
namespace {

struct FloatNumbers {
  std::size_t nan = 0, infinite = 0;
  std::size_t lit = 0, whole = 0;  // finite and not zero; those of them without a fraction
  float largest = 0;
};

FloatNumbers CountedNumbers(const cv::Mat& pixels) {
  FloatNumbers found;
  for (int y = 0; y < pixels.rows; ++y) {
    const float* row = pixels.ptr<float>(y);
    for (int i = 0; i < pixels.cols * pixels.channels(); ++i) {
      const float number = row[i];
      if (!std::isfinite(number)) {
        ++(std::isnan(number) ? found.nan : found.infinite);
      } else if (number != 0) {
        ++found.lit;
        found.whole += number > 0 && number == std::floor(number);
        found.largest = std::max(found.largest, number);
      }
    }
  }
  return found;
}

}  // namespace

void CheckFloatNumbers(StoredPicture& picture) {
  if (picture.pixels.depth() != CV_32F) return;
  const FloatNumbers found = CountedNumbers(picture.pixels);
  if (found.nan + found.infinite > 0)
    picture.warnings.push_back(fmt::format(
        "it holds {} ({} NaN, {} infinite): such pixels get no weight in renderings, and are "
        "black or white in copies of 8 bits",
        Counted(found.nan + found.infinite, "number") + " that say no light", found.nan, found.infinite));
  constexpr double kNearlyAll = 0.99;
  if (!(found.largest > 1) || static_cast<double>(found.whole) < kNearlyAll * static_cast<double>(found.lit))
    return;
  constexpr float kMost8 = 255, kMost16 = 65535;
  const std::string as_levels =
      found.largest > kMost16
          ? std::string("divide them by what full scale is")
          : fmt::format("write levels of sRGB as whole numbers of {} bits, and divide levels of light by {}",
                        found.largest > kMost8 ? 16 : 8, found.largest > kMost8 ? kMost16 : kMost8);
  picture.warnings.push_back(fmt::format(
      "its numbers are whole, up to {:g}, as levels are, but are floating point, which is linear light with "
      "full scale at 1: they are taken for that; {}",
      found.largest, as_levels));
}

}  // namespace ulf
