// Pixels with a meaning. Colour images are B, G, R in memory, as OpenCV reads and writes them.
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <string_view>

namespace ulf {

// How a stored number relates to light: proportional to it, or encoded for a display.
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

// What stands for all the light that a pixel of this depth (CV_8U, ...) can hold.
double FullScale(int depth);

// Three channels of 16 bits from a mosaic, as linear as it was: each missing colour is interpolated along the
// edge, not across it (OpenCV's edge-aware method; an 8-bit mosaic is widened first). Else the image itself.
Image Demosaiced(const Image& image);

// One channel, 8 bits, display-encoded: what features are detected on. A mosaic is not demosaiced for it but
// smoothed over three pixels.
cv::Mat GrayForTracking(const Image& image);

// Colour for people and for every other tool: 8 bits, three channels, sRGB. A mosaic is demosaiced.
cv::Mat Srgb8(const Image& image);

// Three channels of linear light in float, 1.0 at full scale. A mosaic is demosaiced.
cv::Mat LinearFloat(const Image& image);

// Display encoding of linear float light, clamped to 0..1: CV_32FC3 to CV_8UC3.
cv::Mat Srgb8FromLinear(const cv::Mat& linear);

float SrgbFromLinear(float linear);
float LinearFromSrgb(float srgb);

// Reads an image file as it is (8 or 16 bits, colour or grey, or float); throws Error naming the file when it
// is missing, truncated or not an image.
cv::Mat ReadImageFile(const std::string& path);

// Its alpha, CV_8UC1: 255 where a pixel is more than half opaque, else 0. Empty where it has none. Throws as
// ReadImageFile does.
cv::Mat ReadAlpha(const std::string& path);

// True when the file decodes without loss from truncation (end markers of PNG and JPEG present).
bool ImageFileIsWhole(const std::string& path);
// Encoded by the name's ending. Throws DiskFullError or Error; then what was at `path` is there as it was.
void WritePictureFile(const std::string& path, const cv::Mat& srgb8);

}  // namespace ulf
