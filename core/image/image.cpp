#include "core/image/image.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace ulf {
namespace {

// OpenCV names a pattern by the second row's second and third pixels: its BG is GenICam's RG.
int DemosaicCode(Mosaic mosaic) {
  constexpr std::array<int, 5> kCodes{-1, cv::COLOR_BayerBG2BGR_EA, cv::COLOR_BayerGB2BGR_EA,
                                      cv::COLOR_BayerGR2BGR_EA, cv::COLOR_BayerRG2BGR_EA};
  return kCodes[static_cast<std::size_t>(mosaic)];
}

// Maps every 16-bit linear value to 8-bit sRGB; 8-bit input is spread over it first.
const std::vector<std::uint8_t>& SrgbTable() {
  static const std::vector<std::uint8_t> table = [] {
    std::vector<std::uint8_t> values(65536);
    for (int i = 0; i < 65536; ++i)
      values[static_cast<std::size_t>(i)] =
          cv::saturate_cast<std::uint8_t>(255.0f * SrgbFromLinear(static_cast<float>(i) / 65535.0f));
    return values;
  }();
  return table;
}

cv::Mat EncodedFromLinear(const cv::Mat& linear) {
  const auto& table = SrgbTable();
  cv::Mat result(linear.size(), CV_8UC(linear.channels()));
  const int count = linear.cols * linear.channels();
  std::array<std::uint8_t, 256> short_table;
  for (std::size_t i = 0; i < 256; ++i) short_table[i] = table[i * 257];
  for (int y = 0; y < linear.rows; ++y) {
    std::uint8_t* out = result.ptr<std::uint8_t>(y);
    if (linear.depth() == CV_8U) {
      const std::uint8_t* in = linear.ptr<std::uint8_t>(y);
      for (int x = 0; x < count; ++x) out[x] = short_table[in[x]];
    } else if (linear.depth() == CV_16U) {
      const std::uint16_t* in = linear.ptr<std::uint16_t>(y);
      for (int x = 0; x < count; ++x) out[x] = table[in[x]];
    } else {
      const float* in = linear.ptr<float>(y);
      for (int x = 0; x < count; ++x)
        out[x] = table[cv::saturate_cast<std::uint16_t>(std::min(in[x], 1.0f) * 65535.0f)];
    }
  }
  return result;
}

// Returns 8 bits, display-encoded, with the same number of channels.
cv::Mat Encoded8(const Image& image) {
  const cv::Mat pixels = Demosaiced(image).pixels;
  if (image.transfer == Transfer::kLinear) return EncodedFromLinear(pixels);
  if (pixels.depth() == CV_8U) return pixels;
  cv::Mat result;
  pixels.convertTo(result, CV_8U, 255.0 / FullScale(pixels.depth()));
  return result;
}

}  // namespace

double FullScale(int depth) { return depth == CV_8U ? 255 : depth == CV_16U ? 65535 : 1; }

constexpr std::array kMosaicNames{"none", "RGGB", "GRBG", "GBRG", "BGGR"};

const char* Name(Mosaic mosaic) { return kMosaicNames[static_cast<std::size_t>(mosaic)]; }

std::optional<Mosaic> MosaicByName(std::string_view name) {
  for (std::size_t i = 0; i < kMosaicNames.size(); ++i)
    if (name == kMosaicNames[i]) return static_cast<Mosaic>(i);
  return std::nullopt;
}

float SrgbFromLinear(float linear) {
  if (linear <= 0.0031308f) return 12.92f * linear;
  return 1.055f * std::pow(linear, 1.0f / 2.4f) - 0.055f;
}

float LinearFromSrgb(float srgb) {
  if (srgb <= 0.04045f) return srgb / 12.92f;
  return std::pow((srgb + 0.055f) / 1.055f, 2.4f);
}

const std::array<float, 256>& LinearFromSrgb8() {
  static const std::array<float, 256> table = [] {
    std::array<float, 256> values{};
    for (std::size_t i = 0; i < 256; ++i) values[i] = LinearFromSrgb(static_cast<float>(i) / 255.0f);
    return values;
  }();
  return table;
}

Image Demosaiced(const Image& image) {
  if (image.mosaic == Mosaic::kNone) return image;
  cv::Mat mosaic = image.pixels;
  if (mosaic.depth() == CV_8U) image.pixels.convertTo(mosaic, CV_16U, 257);
  Image color{.pixels = {}, .transfer = image.transfer};
  cv::cvtColor(mosaic, color.pixels, DemosaicCode(image.mosaic));
  return color;
}

cv::Mat GrayForTracking(const Image& image) {
  if (image.mosaic != Mosaic::kNone) {
    // Under [1 2 1; 2 4 2; 1 2 1] red and blue weigh a quarter each and green a half, whatever pixel of the
    // pattern lies in the middle: grey without demosaicing, and without a shift.
    cv::Mat gray;
    cv::GaussianBlur(Encoded8({.pixels = image.pixels, .transfer = image.transfer}), gray, {3, 3}, 0, 0,
                     cv::BORDER_REFLECT_101);
    return gray;
  }
  const cv::Mat encoded = Encoded8(image);
  if (encoded.channels() == 1) return encoded;
  cv::Mat gray;
  cv::cvtColor(encoded, gray, cv::COLOR_BGR2GRAY);
  return gray;
}

cv::Mat Srgb8(const Image& image) {
  const cv::Mat encoded = Encoded8(image);
  if (encoded.channels() == 3) return encoded;
  cv::Mat color;
  cv::cvtColor(encoded, color, cv::COLOR_GRAY2BGR);
  return color;
}

cv::Mat LinearFloat(const Image& image) {
  cv::Mat pixels = Demosaiced(image).pixels;
  if (pixels.channels() == 1) {
    cv::Mat color;
    cv::cvtColor(pixels, color, cv::COLOR_GRAY2BGR);
    pixels = color;
  }
  cv::Mat result;
  if (image.transfer == Transfer::kSrgb && pixels.depth() == CV_8U) {
    cv::LUT(pixels, LinearFromSrgb8(), result);
    return result;
  }
  pixels.convertTo(result, CV_32F, 1.0 / FullScale(pixels.depth()));
  if (image.transfer == Transfer::kSrgb)
    for (int y = 0; y < result.rows; ++y) {
      float* row = result.ptr<float>(y);
      for (int x = 0; x < 3 * result.cols; ++x) row[x] = LinearFromSrgb(row[x]);
    }
  return result;
}

cv::Mat Srgb8FromLinear(const cv::Mat& linear) { return EncodedFromLinear(linear); }

}  // namespace ulf
