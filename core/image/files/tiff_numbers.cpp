#include "core/image/files/tiff_numbers.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <vector>

#include "core/image/image.h"

namespace ulf {
namespace {

double FloatOf24Bits(std::uint32_t bits) {
  const int exponent = static_cast<int>(bits >> 16 & 0x7F);
  const double fraction = bits & 0xFFFF, sign = (bits & 0x800000) != 0 ? -1 : 1;
  constexpr int kBias = 63, kFractionBits = 16, kLast = 127;
  if (exponent == kLast) return fraction == 0 ? sign * INFINITY : NAN;
  return exponent == 0 ? sign * std::ldexp(fraction, 1 - kBias - kFractionBits)
                       : sign * std::ldexp(fraction + 65536.0, exponent - kBias - kFractionBits);
}

// Copies samples of a row to every `stride`th number of `to`.
template <typename Sample>
void CopySamples(const TiffNumbers& numbers, const std::uint8_t* row, int count, int block_channels,
                 Sample* to, int stride) {
  const int samples = count * block_channels, bits = numbers.bits;
  const auto put = [&](int i, Sample value) { to[i / block_channels * stride + i % block_channels] = value; };
  const auto at = [&]<typename T>(int i, T) {
    T value;
    std::memcpy(&value, row + static_cast<std::size_t>(i) * sizeof(T), sizeof(T));
    return value;
  };
  if (numbers.is_float) {
    for (int i = 0; i < samples; ++i) {
      double value = 0;
      if (bits == 16)
        value = static_cast<float>(at(i, cv::float16_t()));
      else if (bits == 24)
        value = FloatOf24Bits(row[3 * i] | row[3 * i + 1] << 8 |
                              static_cast<std::uint32_t>(row[3 * i + 2]) << 16);
      else
        value = bits == 32 ? static_cast<double>(at(i, float())) : at(i, double());
      put(i, static_cast<Sample>(value));
    }
    return;
  }
  if (bits == 8 || bits == 16 || bits == 32) {
    constexpr int kToSixteen = 16;
    for (int i = 0; i < samples; ++i)
      put(i, static_cast<Sample>(bits == 8    ? row[i]
                                 : bits == 16 ? at(i, std::uint16_t())
                                              : at(i, std::uint32_t()) >> kToSixteen));
    return;
  }
  const std::uint32_t most = (1U << bits) - 1, full = sizeof(Sample) == 1 ? 255 : 65535;
  for (int i = 0, bit = 0; i < samples; ++i, bit += bits) {
    std::uint32_t value = 0;
    for (int b = bit; b < bit + bits; ++b) value = value << 1 | (row[b / 8] >> (7 - b % 8) & 1U);
    put(i, static_cast<Sample>(numbers.is_index ? value : (value * full + most / 2) / most));
  }
}

}  // namespace

void CopyTiffRow(const TiffNumbers& numbers, const std::uint8_t* row, int count, int block_channels, int x,
                 int y, int first_channel, cv::Mat& samples) {
  const int channels = samples.channels(), at = x * channels + first_channel;
  if (samples.depth() == CV_8U)
    CopySamples(numbers, row, count, block_channels, samples.ptr<std::uint8_t>(y) + at, channels);
  else if (samples.depth() == CV_16U)
    CopySamples(numbers, row, count, block_channels, samples.ptr<std::uint16_t>(y) + at, channels);
  else
    CopySamples(numbers, row, count, block_channels, samples.ptr<float>(y) + at, channels);
}

cv::Mat FirstChannels(const cv::Mat& samples, int count) {
  if (samples.channels() == count) return samples;
  std::vector<cv::Mat> planes;
  cv::split(samples, planes);
  planes.resize(static_cast<std::size_t>(count));
  cv::Mat first;
  cv::merge(planes, first);
  return first;
}

cv::Mat ThroughPalette(const cv::Mat& indices, const std::array<const std::uint16_t*, 3>& rgb, int count) {
  std::uint16_t most = 0;
  for (const std::uint16_t* color : rgb) most = std::max(most, *std::max_element(color, color + count));
  const int divisor = most > 255 ? 257 : 1;
  const auto level = [&](std::uint16_t value) {
    return cv::saturate_cast<std::uint8_t>((value + divisor / 2) / divisor);
  };
  cv::Mat bgr(indices.size(), CV_8UC3);
  for (int y = 0; y < bgr.rows; ++y)
    for (int x = 0; x < bgr.cols; ++x) {
      const int i = indices.at<std::uint8_t>(y, x);
      bgr.at<cv::Vec3b>(y, x) = {level(rgb[2][i]), level(rgb[1][i]), level(rgb[0][i])};
    }
  return bgr;
}

bool ApplyTransferFunction(const std::array<const std::uint16_t*, 3>& rgb, cv::Mat& pixels) {
  const auto apply = [&]<typename Number>(Number most) {
    const int channels = pixels.channels(), count = most + 1;
    const double full = most;
    cv::Mat tables(1, count, pixels.type());
    double largest = 0;
    for (int i = 0; i < count; ++i)
      for (int c = 0; c < channels; ++c) {
        const std::uint16_t* own = channels == 3 ? rgb[static_cast<std::size_t>(2 - c)] : nullptr;
        const std::uint16_t* curve = own ? own : rgb[0];
        const double level = full * SrgbFromLinear(static_cast<float>(curve[i] / 65535.0));
        largest = std::max(largest, std::abs(level - i) / full);
        tables.ptr<Number>()[i * channels + c] = cv::saturate_cast<Number>(level);
      }
    constexpr double kNearSrgb = 0.035;  // an exponent of 2.2, the default of the tag, differs by as much
    if (largest < kNearSrgb) return false;
    for (int y = 0; y < pixels.rows; ++y)
      for (int i = 0; i < pixels.cols * channels; ++i) {
        Number& number = pixels.ptr<Number>(y)[i];
        number = tables.ptr<Number>()[number * channels + i % channels];
      }
    return true;
  };
  return pixels.depth() == CV_8U ? apply(std::uint8_t{255}) : apply(std::uint16_t{65535});
}

void WarnOfUnusedBits(unsigned largest, int bits, const cv::Mat& samples, StoredPicture& picture) {
  constexpr int kFewestBits = 8;
  const int used = std::bit_width(largest);
  if (used < kFewestBits || used >= bits || largest + 1 != 1U << used) return;
  double most = 0;
  cv::minMaxLoc(samples.reshape(1), nullptr, &most);
  if (most / FullScale(samples.depth()) * (std::exp2(bits) - 1) > largest + 0.5) return;
  picture.warnings.push_back(
      fmt::format("its largest number is {} by its tag MaxSampleValue, of {} bits: its numbers are taken as "
                  "they are, of {} bits; if it looks dark, multiply them by {}",
                  largest, used, bits, 1U << (bits - used)));
}

void DivideByAlpha(const cv::Mat& alpha, cv::Mat& pixels) {
  const double full = FullScale(pixels.depth());
  const int channels = pixels.channels();
  const auto divide = [&]<typename Number>(Number) {
    for (int y = 0; y < pixels.rows; ++y)
      for (int x = 0; x < pixels.cols; ++x) {
        const double opaque = static_cast<double>(alpha.at<Number>(y, x)) / full;
        auto* pixel = pixels.ptr<Number>(y) + x * channels;
        if (opaque > 0 && opaque < 1)
          for (int c = 0; c < channels; ++c)
            pixel[c] = cv::saturate_cast<Number>(static_cast<double>(pixel[c]) / opaque);
      }
  };
  if (pixels.depth() == CV_8U) divide(std::uint8_t());
  if (pixels.depth() == CV_16U) divide(std::uint16_t());
  if (pixels.depth() == CV_32F) divide(float());
}

}  // namespace ulf
