#include "core/image/image.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <set>
#include <vector>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/lowercase.h"
#include "core/image/claimed_size.h"
#include "core/image/exr_file.h"
#include "core/image/image_header.h"
#include "core/image/raw_file.h"

namespace ulf {
namespace {

// OpenCV names a pattern by the second row's second and third pixels: its BG is GenICam's RG.
int DemosaicCode(Mosaic mosaic) {
  switch (mosaic) {
    case Mosaic::kRggb:
      return cv::COLOR_BayerBG2BGR_EA;
    case Mosaic::kGrbg:
      return cv::COLOR_BayerGB2BGR_EA;
    case Mosaic::kGbrg:
      return cv::COLOR_BayerGR2BGR_EA;
    default:
      return cv::COLOR_BayerRG2BGR_EA;
  }
}

// 8-bit sRGB for every 16-bit linear value; 8-bit input is spread over it first.
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

// 8 bits, display-encoded, as many channels as there are.
cv::Mat Encoded8(const Image& image) {
  const cv::Mat pixels = Demosaiced(image).pixels;
  if (image.transfer == Transfer::kLinear) return EncodedFromLinear(pixels);
  if (pixels.depth() == CV_8U) return pixels;
  cv::Mat result;
  pixels.convertTo(result, CV_8U, 255.0 / FullScale(pixels.depth()));
  return result;
}

}  // namespace

double FullScale(int depth) {
  switch (depth) {
    case CV_8U:
      return 255.0;
    case CV_16U:
      return 65535.0;
    default:
      return 1.0;
  }
}

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
  cv::Mat result(pixels.size(), CV_32FC3);
  if (image.transfer == Transfer::kSrgb && pixels.depth() == CV_8U) {
    const std::array<float, 256>& table = LinearFromSrgb8();
    for (int y = 0; y < pixels.rows; ++y) {
      const std::uint8_t* in = pixels.ptr<std::uint8_t>(y);
      float* out = result.ptr<float>(y);
      for (int x = 0; x < 3 * pixels.cols; ++x) out[x] = table[in[x]];
    }
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

bool ImageFileIsWhole(const std::string& path) {
  std::error_code unknown;
  if (!std::filesystem::is_regular_file(path, unknown)) return false;
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  if (!file) return false;
  const std::streamoff size = file.tellg();
  if (size < 12) return false;
  std::array<unsigned char, 8> head{};
  file.seekg(0);
  file.read(reinterpret_cast<char*>(head.data()), head.size());
  const bool is_png = head[0] == 0x89 && head[1] == 'P';
  const bool is_jpeg = head[0] == 0xFF && head[1] == 0xD8;
  if (!is_png && !is_jpeg) return true;  // other decoders report truncation themselves
  // The end marker may be followed by padding or a trailer of the camera's: look for it from the end.
  const std::streamoff window = std::min<std::streamoff>(size, is_png ? 64 : 65536);
  std::string tail(static_cast<std::size_t>(window), '\0');
  file.seekg(size - window);
  file.read(tail.data(), window);
  return is_png ? tail.find("IEND") != std::string::npos : tail.rfind("\xFF\xD9") != std::string::npos;
}

bool HasImageEnding(const std::filesystem::path& path) {
  static const std::set<std::string> kEndings = {".png",  ".jpg", ".jpeg", ".tif", ".tiff", ".bmp",
                                                 ".webp", ".exr", ".ppm",  ".pgm", ".hdr"};
  return kEndings.contains(Lowercase(path.extension().string())) || IsRawFile(path);
}

std::string PngBytes(const cv::Mat& pixels) {
  std::vector<unsigned char> bytes;
  cv::imencode(".png", pixels, bytes);
  return {bytes.begin(), bytes.end()};
}

void WritePictureFile(const std::string& path, const cv::Mat& srgb8) {
  std::vector<unsigned char> bytes;
  bool encoded = false;
  try {
    encoded = cv::imencode(Lowercase(std::filesystem::path(path).extension().string()), srgb8, bytes);
  } catch (const cv::Exception&) {
  }
  if (!encoded) throw Error("{}: give a picture's name, ending in .png or .jpg", path);
  WriteFileAtomically(path, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

namespace {

void RequireWholeFile(const std::string& path) {
  if (std::error_code unknown; std::filesystem::exists(path, unknown)) RequireRegularFile(path);
  if (!std::ifstream(path))
    throw Error("{}: the image is missing or cannot be read; restore it (of a light field: ulf repair DIR)",
                path);
  if (!ImageFileIsWhole(path))
    throw Error(
        "{}: the image is truncated; copy it again from its source (of a light field: ulf repair DIR)", path);
}

cv::Mat Decoded(const std::string& path) {
  const std::uintmax_t bytes = std::filesystem::file_size(path);
  std::ifstream file(path, std::ios::binary);
  bool is_known = true;
  constexpr double kBytesOfPixel =
      6;  // of the largest Netpbm; Radiance's floats are twice that, the others half
  if (const auto header = ReadImageHeader(path))
    RequirePixelsOfFile(path, bytes, static_cast<double>(header->width) * static_cast<double>(header->height),
                        header->channels * header->bits / 8.0);
  else if (const auto size = ClaimedSize(file))
    RequirePixelsOfFile(path, bytes, size->area(), kBytesOfPixel);
  else
    is_known = false;
  // OpenCV would decode other kinds, too, but takes the memory that they claim.
  cv::Mat pixels;
  try {
    if (is_known) pixels = cv::imread(path, cv::IMREAD_UNCHANGED | cv::IMREAD_IGNORE_ORIENTATION);
  } catch (const cv::Exception&) {
  }
  if (pixels.empty())
    throw Error(
        "{}: cannot be decoded as an image: it is damaged, or of another kind than PNG, JPEG, TIFF, EXR, "
        "BMP, WebP, "
        "PPM, PGM, HDR and raw; copy it again from its source, or convert it (of a light field: ulf repair "
        "DIR)",
        path);
  return pixels;
}

}  // namespace

cv::Mat ReadImageFile(const std::string& path) {
  RequireWholeFile(path);
  if (IsRawFile(path)) return ReadRawFile(path);
  if (path.ends_with(".exr")) return ReadExr(path);
  cv::Mat pixels = Decoded(path);
  if (pixels.channels() == 4) cv::cvtColor(pixels, pixels, cv::COLOR_BGRA2BGR);
  return pixels;
}

Transfer TransferOfFile(const std::filesystem::path& path) {
  return path.extension() == ".exr" || IsRawFile(path) ? Transfer::kLinear : Transfer::kSrgb;
}

cv::Mat ReadAlpha(const std::string& path) {
  RequireWholeFile(path);
  if (path.ends_with(".exr") || IsRawFile(path)) return {};
  const cv::Mat pixels = Decoded(path);
  cv::Mat alpha;
  if (pixels.channels() != 4) {
    const auto header = ReadImageHeader(path);
    if (!header || !header->transparent_color) return {};
    const auto& [red, green, blue] = *header->transparent_color;
    const cv::Scalar color = pixels.channels() == 1 ? cv::Scalar::all(red) : cv::Scalar(blue, green, red);
    cv::inRange(pixels, color, color, alpha);
    return ~alpha;
  }
  cv::extractChannel(pixels, alpha, 3);
  return alpha >= (alpha.depth() == CV_16U ? 1 << 15 : alpha.depth() == CV_8U ? 128 : 0.5);
}

}  // namespace ulf
