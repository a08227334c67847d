// Writes picture files of many layouts with six patches of known colours, by the libraries of their formats,
// for tests of reading.
#pragma once

#include <array>
#include <filesystem>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

namespace ulf::test {

// The colours are 8-bit sRGB, R G B; three patches are in the upper row, three in the lower one, each
// kPatchPx wide and high.
inline constexpr std::array<std::array<int, 3>, 6> kPatches{
    {{200, 50, 50}, {50, 200, 50}, {50, 50, 200}, {200, 200, 50}, {128, 128, 128}, {235, 160, 120}}};
inline constexpr int kPatchPx = 20;

// Return the picture itself, B G R, CV_8UC3, and its grey form, which is the green channel.
cv::Mat PatchPicture();
cv::Mat PatchGrey();

// Returns the largest difference in the middle of any patch, in levels of 255; `read` is sRGB of 8 or 16 bits
// or linear float, with one channel (compared with the green one) or three.
double LargestPatchError(const cv::Mat& read);

struct TiffLayout {
  int bits = 8;
  int format = 1;       // SampleFormat: 1 whole numbers, 3 floating point
  int photometric = 2;  // 0 white is zero, 1 black is zero, 2 RGB, 3 palette, 5 inks, 8 CIE L*a*b*
  bool planes = false, tiles = false;
  int predictor = 1, compression = 1;
  const char* mode = "w";  // of TIFFOpen: "wb" big-endian, "w8" BigTIFF
  int orientation = 1;
  int alpha = -1;  // ExtraSamples' kind of a further channel at 128 of 255; -1: none
  std::string icc = {};
  bool is_inside_thumbnail = false;  // in a directory inside the thumbnail's
  int thumbnail_first = 0;           // pages of half the size before it, marked as such
  int further_pages = 0;
  std::string xmp = {};
  float across = 0, down = 0;  // pixels to an inch; 0: not said
};
void WriteTiffSample(const std::filesystem::path& path, const TiffLayout& layout);

struct PngLayout {
  int bits = 8;
  bool grey = false, palette = false, interlaced = false;
  double gamma = 0;                    // chunk gAMA, and the numbers are light to this power; 0: none
  std::vector<double> primaries = {};  // chunk cHRM: white, red, green, blue; the numbers stay
  std::string icc = {};
  std::string code = {};  // chunk cICP, four bytes
};
void WritePngSample(const std::filesystem::path& path, const PngLayout& layout);

// Writes a plain TIFF of these numbers (CV_8UC3 or CV_16UC3), in their order; `white`, `most`: its tags
// WhitePoint and MaxSampleValue.
void WriteTiffNumbers(const std::filesystem::path& path, const cv::Mat& samples, int photometric,
                      const std::optional<std::array<float, 2>>& white = {}, int most = 0);

// Returns the PNG with a chunk behind its header, or before its end.
std::string WithPngChunk(const std::string& png, const std::string& name, const std::string& content,
                         bool at_end = false);
// Returns the plain WebP of 60x40 as an extended one with that chunk, which `flag` of its header announces.
std::string WithWebpChunk(const std::string& webp, char flag, const std::string& name,
                          const std::string& content);

// Returns an ICC profile: "sRGB", "P3" (Display P3), "linear" (sRGB's primaries), "grey" (exponent 1.8),
// "CMYK" or "Lab".
std::string IccProfile(const std::string& kind);
// Returns the numbers that mean the colours of `srgb8` in the RGB space of such a profile: B G R.
cv::Mat EncodedIn(const std::string& kind, const cv::Mat& srgb8);

// Returns a JPEG segment APP1 with an Exif block that says when the picture was taken ("2026:11:29
// 10:11:12"), and its orientation. `is_adobe_rgb`: with DCF's mark R03.
std::string ExifSegment(const std::string& taken, int orientation = 1, const std::string& thumbnail_jpeg = {},
                        bool is_adobe_rgb = false);
// Returns the JPEG with that segment behind its start.
std::string WithSegment(const std::string& jpeg, const std::string& segment);

}  // namespace ulf::test
