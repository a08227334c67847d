#include "core/image/files/png_picture.h"

#include <fmt/core.h>
#include <png.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <csetjmp>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <sstream>

#include "core/base/error.h"
#include "core/image/files/exif.h"
#include "core/image/files/picture_colors.h"
#include "core/image/files/picture_projection.h"
#include "core/image/image.h"

namespace ulf {
namespace {

struct PngInput {
  std::string_view bytes;
  std::size_t at = 0;
};

struct PngContent {
  cv::Mat pixels;  // as libpng gives them: grey, grey and alpha, B G R, or B G R A
  ColorTags claim;
  bool is_srgb = false, has_code = false, is_animated = false;
  std::string exif, xmp;
  png_uint_32 density[2] = {};     // pixels per metre or another length, across and down
  std::array<png_byte, 4> code{};  // cICP: primaries, curve, matrix, range
  std::array<char, 256> error{}, profile_problem{};
};

void KeepError(png_structp png, png_const_charp words) {
  auto& error = static_cast<PngContent*>(png_get_error_ptr(png))->error;
  std::strncpy(error.data(), words, error.size() - 1);
  std::longjmp(png_jmpbuf(png), 1);
}

// The library drops a profile that it finds fault with.
void KeepProfileWarning(png_structp png, png_const_charp words) {
  auto& problem = static_cast<PngContent*>(png_get_error_ptr(png))->profile_problem;
  if (std::strncmp(words, "iCCP", 4) == 0) std::strncpy(problem.data(), words, problem.size() - 1);
}

void ReadBytes(png_structp png, png_bytep to, std::size_t size) {
  auto& input = *static_cast<PngInput*>(png_get_io_ptr(png));
  if (size > input.bytes.size() - input.at) png_error(png, "the file ends too early");
  std::memcpy(to, input.bytes.data() + input.at, size);
  input.at += size;
}

// Decodes a profile as ImageMagick and similar programs write it: its name, its length, and its bytes in
// hexadecimal digits.
std::string OfRawProfile(std::string_view text) {
  std::istringstream words{std::string(text)};
  std::string name, bytes;
  std::size_t size = 0;
  words >> name >> size;
  char high = 0, low = 0;
  while (bytes.size() < size && words >> high >> low) {
    const char digits[] = {high, low, '\0'};
    bytes += static_cast<char>(std::strtol(digits, nullptr, 16));
  }
  return bytes;
}

void ReadClaim(png_structp png, png_infop info, PngContent& content) {
  png_unknown_chunkp unknown = nullptr;
  const int count = png_get_unknown_chunks(png, info, &unknown);
  for (int i = 0; i < count; ++i) {
    if ((unknown[i].location & PNG_AFTER_IDAT) != 0) continue;  // neither may follow the pixels
    if (std::memcmp(unknown[i].name, "acTL", 4) == 0) content.is_animated = true;
    if (std::memcmp(unknown[i].name, "cICP", 4) == 0 && unknown[i].size == content.code.size()) {
      content.has_code = true;
      std::memcpy(content.code.data(), unknown[i].data, content.code.size());
    }
  }
  png_bytep exif = nullptr;
  if (png_uint_32 exif_bytes = 0; png_get_eXIf_1(png, info, &exif_bytes, &exif) != 0)
    content.exif.assign(reinterpret_cast<const char*>(exif), exif_bytes);
  int unit = 0;
  png_get_pHYs(png, info, &content.density[0], &content.density[1], &unit);
  png_textp texts = nullptr;
  const int text_count = png_get_text(png, info, &texts, nullptr);
  for (int i = 0; i < text_count; ++i) {
    if (std::strcmp(texts[i].key, "XML:com.adobe.xmp") == 0) content.xmp = texts[i].text;
    if (std::strcmp(texts[i].key, "Raw profile type xmp") == 0) content.xmp = OfRawProfile(texts[i].text);
    if (std::strcmp(texts[i].key, "Raw profile type exif") == 0 && content.exif.empty())
      content.exif = OfRawProfile(texts[i].text);
  }
  png_charp name = nullptr;
  png_bytep profile = nullptr;
  png_uint_32 size = 0;
  int method = 0, intent = 0;
  if (png_get_iCCP(png, info, &name, &method, &profile, &size) != 0) {
    content.claim.icc.assign(reinterpret_cast<const char*>(profile), size);
    return;
  }
  if (png_get_sRGB(png, info, &intent) != 0) {
    content.is_srgb = true;
    return;
  }
  double gamma = 0;
  if (png_get_gAMA(png, info, &gamma) != 0 && gamma > 0) content.claim.exponent = 1 / gamma;
  Primaries xy{};
  bool has_other_primaries = false;
  if (png_get_cHRM(png, info, &xy[6], &xy[7], &xy[0], &xy[1], &xy[2], &xy[3], &xy[4], &xy[5]) != 0) {
    content.claim.primaries = xy;
    constexpr double kSame = 0.002;
    for (std::size_t i = 0; i < xy.size(); ++i)
      has_other_primaries = has_other_primaries || std::abs(xy[i] - kSrgbPrimaries[i]) > kSame;
  }
  // Programs write 1/2.2 for sRGB (the standard's own advice for sRGB is this number).
  constexpr double kOfSrgb = 0.45455, kNear = 0.0015;
  if (std::abs(gamma - kOfSrgb) < kNear && !has_other_primaries) content.claim.exponent.reset();
}

// libpng reports an error by a longjmp out of this function: nothing here may have a destructor. The same
// holds for Encode().
bool DecodePng(png_structp png, png_infop info, PngContent& content) {
  if (setjmp(png_jmpbuf(png))) return false;
  png_set_keep_unknown_chunks(png, PNG_HANDLE_CHUNK_ALWAYS, reinterpret_cast<png_const_bytep>("cICP\0acTL"),
                              2);
  png_read_info(png, info);
  png_set_expand(png);
  if (png_get_bit_depth(png, info) == 16) png_set_swap(png);
  png_set_bgr(png);
  const int passes = png_set_interlace_handling(png);
  png_read_update_info(png, info);
  const int depth = png_get_bit_depth(png, info) == 16 ? CV_16U : CV_8U;
  content.pixels.create(static_cast<int>(png_get_image_height(png, info)),
                        static_cast<int>(png_get_image_width(png, info)),
                        CV_MAKETYPE(depth, png_get_channels(png, info)));
  for (int pass = 0; pass < passes; ++pass)
    for (int y = 0; y < content.pixels.rows; ++y) png_read_row(png, content.pixels.ptr(y), nullptr);
  png_read_end(png, info);  // with texts and Exif behind the pixels
  ReadClaim(png, info, content);
  return true;
}

// Follows ITU-T H.273. An empty claim means sRGB.
std::optional<ColorTags> ClaimOfCode(const std::array<png_byte, 4>& code) {
  constexpr Primaries kBt2020{0.708, 0.292, 0.170, 0.797, 0.131, 0.046, 0.3127, 0.3290},
      kDisplayP3{0.680, 0.320, 0.265, 0.690, 0.150, 0.060, 0.3127, 0.3290};
  static const std::map<png_byte, double> kExponents{{4, 2.2}, {5, 2.8}, {8, 1.0}};
  // sRGB, and television's curves, which players show unchanged.
  static const std::set<png_byte> kShownAsSrgb{1, 2, 6, 13, 14, 15};
  ColorTags claim;
  if (code[0] == 9)
    claim = {.primaries = kBt2020, .name = "BT.2020 (cICP)"};
  else if (code[0] == 12)
    claim = {.primaries = kDisplayP3, .name = "Display P3 (cICP)"};
  else if (code[0] != 1 && code[0] != 2)
    return std::nullopt;
  if (const auto exponent = kExponents.find(code[1]); exponent != kExponents.end())
    claim.exponent = exponent->second;
  else if (!kShownAsSrgb.contains(code[1]))
    return std::nullopt;
  return code[2] == 0 && code[3] == 1 ? std::optional(claim) : std::nullopt;
}

void WriteBytes(png_structp png, png_bytep from, std::size_t size) {
  static_cast<std::string*>(png_get_io_ptr(png))->append(reinterpret_cast<const char*>(from), size);
}

void NothingToFlush(png_structp) {}

bool Encode(png_structp png, png_infop info, const cv::Mat& pixels) {
  if (setjmp(png_jmpbuf(png))) return false;
  constexpr int kRunLengths = 3, kFastest = 1;
  png_set_filter(png, PNG_FILTER_TYPE_BASE, PNG_FILTER_SUB);
  png_set_compression_level(png, kFastest);
  png_set_compression_strategy(png, kRunLengths);
  const int color = pixels.channels() == 1   ? PNG_COLOR_TYPE_GRAY
                    : pixels.channels() == 3 ? PNG_COLOR_TYPE_RGB
                                             : PNG_COLOR_TYPE_RGB_ALPHA;
  png_set_IHDR(png, info, static_cast<png_uint_32>(pixels.cols), static_cast<png_uint_32>(pixels.rows),
               pixels.depth() == CV_16U ? 16 : 8, color, PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
               PNG_FILTER_TYPE_DEFAULT);
  png_write_info(png, info);
  png_set_bgr(png);
  if (pixels.depth() == CV_16U) png_set_swap(png);
  for (int y = 0; y < pixels.rows; ++y) png_write_row(png, const_cast<png_bytep>(pixels.ptr(y)));
  png_write_end(png, info);
  return true;
}

}  // namespace

StoredPicture ReadPng(std::string_view bytes, const std::string& name) {
  PngInput input{bytes};
  PngContent content;
  png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &content, KeepError, KeepProfileWarning);
  png_infop info = png_create_info_struct(png);
  png_set_read_fn(png, &input, ReadBytes);
  const bool is_whole = DecodePng(png, info, content);
  png_destroy_read_struct(&png, &info, nullptr);
  if (!is_whole)
    throw Error(
        "{}: the image is truncated or damaged ({}); copy it again from its source (of a light field: ulf "
        "repair DIR)",
        name, content.error.data());
  RequireOneLens(content.xmp, name);
  StoredPicture picture;
  TakePixels(content.pixels, picture);
  if (!content.exif.empty())
    NoteOrientation(
        ReadExif((content.exif.starts_with("Exif") ? "" : std::string("Exif\0\0", 6)) + content.exif)
            .orientation,
        picture);
  WarnOfPixelAspect(content.density[0], content.density[1], picture);
  if (content.is_animated)
    picture.warnings.emplace_back(
        "it is animated (APNG): its first picture is taken, export the others as files of their own");
  if (content.profile_problem[0] != '\0' && content.claim.icc.empty() && !content.has_code)
    picture.warnings.push_back(
        fmt::format("its colour profile cannot be used ({}): its colours are taken for sRGB",
                    content.profile_problem.data()));
  if (content.has_code) {
    constexpr int kPq = 16, kHlg = 18;
    if (content.code[1] == kPq || content.code[1] == kHlg)
      throw Error(
          "{}: has a high dynamic range ({} by its chunk cICP), which is not read from PNG; convert it to "
          "OpenEXR, or to PNG with sRGB",
          name, content.code[1] == kPq ? "PQ" : "HLG");
    if (const auto claim = ClaimOfCode(content.code))
      content.claim = *claim;
    else
      picture.warnings.push_back(
          fmt::format("its chunk cICP ({}, {}, {}, {}) is not understood: its colours are taken for sRGB",
                      content.code[0], content.code[1], content.code[2], content.code[3]));
  }
  if (!content.is_srgb || content.has_code) ConvertToSrgb(content.claim, picture);
  return picture;
}

std::string PngBytes(const cv::Mat& pixels) {
  const int channels = pixels.channels(), depth = pixels.depth();
  std::string bytes;
  PngContent report;
  bool is_done = false;
  if (!pixels.empty() && (depth == CV_8U || depth == CV_16U) &&
      (channels == 1 || channels == 3 || channels == 4)) {
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, &report, KeepError, KeepProfileWarning);
    png_infop info = png_create_info_struct(png);
    png_set_write_fn(png, &bytes, WriteBytes, NothingToFlush);
    is_done = Encode(png, info, pixels);
    png_destroy_write_struct(&png, &info);
  }
  if (!is_done)
    throw Error("a picture of {}x{} with {} channels of OpenCV's depth {} cannot be written as PNG{}",
                pixels.cols, pixels.rows, channels, depth,
                report.error[0] != '\0' ? fmt::format(": {}", report.error.data()) : "");
  return bytes;
}

cv::Mat Srgb16FromLinear(const cv::Mat& linear) {
  constexpr float kFull = std::numeric_limits<std::uint16_t>::max();
  cv::Mat encoded(linear.size(), CV_16UC3);
  for (int y = 0; y < linear.rows; ++y) {
    const float* in = linear.ptr<float>(y);
    std::uint16_t* out = encoded.ptr<std::uint16_t>(y);
    for (int x = 0; x < 3 * linear.cols; ++x)
      out[x] = cv::saturate_cast<std::uint16_t>(kFull * SrgbFromLinear(std::clamp(in[x], 0.0f, 1.0f)));
  }
  return encoded;
}

}  // namespace ulf
