// Pixels with their meaning: transfer function and mosaic. Colour images are B, G, R in memory, as in OpenCV.
#pragma once

#include <array>
#include <filesystem>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
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

// Reads an image file without conversion (8 or 16 bits or float, colour or grey; alpha is dropped, Exif
// orientation ignored); a camera's raw file as raw_file.h reads it. Throws Error naming the file when it is missing, truncated or not an image.
cv::Mat ReadImageFile(const std::string& path);
// How the numbers of such a file relate to light, by the ending of its name: linear in EXR and raw files.
Transfer TransferOfFile(const std::filesystem::path& path);

// The alpha channel of an image file, CV_8UC1: 255 where a pixel is at least half opaque, else 0. Empty where
// the file has none. Throws as ReadImageFile() does.
cv::Mat ReadAlpha(const std::string& path);

// Whether a PNG or JPEG file has its end marker; true for other kinds, whose decoders report truncation.
bool ImageFileIsWhole(const std::string& path);
// Whether the file's name has the ending of a picture that ReadImageFile() reads, in lower or upper case.
bool HasImageEnding(const std::filesystem::path& path);

// The picture as a PNG file: 8 or 16 bits, one, three or four channels.
std::string PngBytes(const cv::Mat& pixels);
// Encodes by the ending of `path`. Throws DiskFullError or Error; then the file at `path`, if there was one,
// is unchanged.
void WritePictureFile(const std::string& path, const cv::Mat& srgb8);

}  // namespace ulf
