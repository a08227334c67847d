// Pixels with their transfer function and mosaic. Colour images are B, G, R in memory, as in OpenCV.
#pragma once

#include <array>
#include <opencv2/core.hpp>
#include <optional>
#include <string_view>

namespace ulf {

// How a stored number relates to light: proportional, or encoded for a display (sRGB, IEC 61966-2-1).
enum class Transfer { kLinear, kSrgb };

// A mosaic's pattern is named by its first two pixels of the first two rows, as in GenICam.
enum class Mosaic { kNone, kRggb, kGrbg, kGbrg, kBggr };
const char* Name(Mosaic mosaic);                            // "RGGB", or "none"
std::optional<Mosaic> MosaicByName(std::string_view name);  // nullopt if there is no such name

struct Image {
  cv::Mat pixels;  // CV_8UC1/3, CV_16UC1/3 or CV_32FC1/3; integer types are full scale at their maximum
  Transfer transfer = Transfer::kSrgb;
  Mosaic mosaic = Mosaic::kNone;  // only with one channel

  int width() const { return pixels.cols; }
  int height() const { return pixels.rows; }
  bool empty() const { return pixels.empty(); }
};

// Returns the number that means full scale at this depth (CV_8U: 255, CV_16U: 65535, CV_32F: 1).
double FullScale(int depth);

// Interpolates a mosaic's missing colours with OpenCV's edge-aware method: three channels of 16 bits with the
// same transfer function (an 8-bit mosaic is widened first). An image without a mosaic is returned unchanged.
Image Demosaiced(const Image& image);

// Converts to the image that features are detected in: one channel, 8 bits, display-encoded. A mosaic is
// smoothed over three pixels instead of demosaiced.
cv::Mat GrayForTracking(const Image& image);

// Converts for display and for other programs: 8 bits, three channels, sRGB. A mosaic is demosaiced.
cv::Mat Srgb8(const Image& image);

// Converts to three channels of linear light in float, 1.0 at full scale. A mosaic is demosaiced.
cv::Mat LinearFloat(const Image& image);

// Encodes linear float light, clamped to 0..1, for display: CV_32FC3 to CV_8UC3.
cv::Mat Srgb8FromLinear(const cv::Mat& linear);

// These convert one value, 0 to 1.
float SrgbFromLinear(float linear);
float LinearFromSrgb(float srgb);
const std::array<float, 256>& LinearFromSrgb8();  // for every 8-bit value

}  // namespace ulf
