// Pixels with their meaning: transfer function and mosaic. Colour images are B, G, R in memory, as in OpenCV.
#pragma once

#include <array>
#include <opencv2/core.hpp>
#include <optional>
#include <string_view>

namespace ulf {

// How a stored number relates to light: proportional (kLinear), or encoded for a display (kSrgb, IEC
// 61966-2-1).
enum class Transfer { kLinear, kSrgb };

// A mosaic's pattern, named by its first two pixels of the first row (GenICam's names); kNone: not a mosaic.
enum class Mosaic { kNone, kRggb, kGrbg, kGbrg, kBggr };
const char* Name(Mosaic mosaic);                            // "RGGB"; "none"
std::optional<Mosaic> MosaicByName(std::string_view name);  // none: there is no such pattern

struct Image {
  cv::Mat pixels;  // CV_8UC1/3, CV_16UC1/3 or CV_32FC1/3; integer types are full scale at their maximum
  Transfer transfer = Transfer::kSrgb;
  Mosaic mosaic = Mosaic::kNone;  // only with one channel

  int width() const { return pixels.cols; }
  int height() const { return pixels.rows; }
  bool empty() const { return pixels.empty(); }
};

// The number that means full scale in pixels of this depth (CV_8U: 255, CV_16U: 65535, CV_32F: 1).
double FullScale(int depth);

// Interpolates a mosaic's missing colours with OpenCV's edge-aware method: three channels of 16 bits with the
// same transfer function (an 8-bit mosaic is widened first). An image without a mosaic is returned unchanged.
Image Demosaiced(const Image& image);

// The image that features are detected in: one channel, 8 bits, display-encoded. A mosaic is smoothed over
// three pixels instead of demosaiced.
cv::Mat GrayForTracking(const Image& image);

// The image for display and for other programs: 8 bits, three channels, sRGB. A mosaic is demosaiced.
cv::Mat Srgb8(const Image& image);

// Three channels of linear light in float, 1.0 at full scale. A mosaic is demosaiced.
cv::Mat LinearFloat(const Image& image);

// Display encoding of linear float light, clamped to 0..1: CV_32FC3 to CV_8UC3.
cv::Mat Srgb8FromLinear(const cv::Mat& linear);

float SrgbFromLinear(float linear);
float LinearFromSrgb(float srgb);
const std::array<float, 256>& LinearFromSrgb8();  // for every 8-bit value

}  // namespace ulf
