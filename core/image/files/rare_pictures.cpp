#include "core/image/files/picture_codecs.h"

#include <fmt/core.h>
#include <stb_image.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstring>
#include <memory>
#include <opencv2/imgproc.hpp>
#include <sstream>

#include "core/base/error.h"
#include "core/ffmpeg/ffmpeg_calls.h"
#include "core/image/files/image_header.h"
#include "core/image/files/picture_colors.h"
#include "core/image/files/stored_picture.h"

namespace ulf {
namespace {

// A header has its numbers within this many bytes.
constexpr std::size_t kMostOfHead = 64 << 10;

[[noreturn]] void RefuseDamagedPicture(const std::string& name, const std::string& words) {
  throw Error(
      "{}: the image is truncated or damaged ({}); copy it again from its source (of a light field: ulf "
      "repair DIR)",
      name, words);
}

// Decodes a picture of a size that fits (ClaimedSize): the library may read a header another way.
FfmpegOwned<AVFrame> DecodeOne(AVCodecID kind, std::string_view bytes, const std::string& name) {
  std::istringstream stream{std::string(bytes.substr(0, kMostOfHead))};
  const auto claimed = ClaimedSize(stream);
  if (!claimed) RefuseDamagedPicture(name, "its header");
  RouteFfmpegLog();
  const AVCodec* decoder = Ffmpeg().avcodec_find_decoder(kind);
  if (!decoder) throw Error("{}: FFmpeg has no decoder for this kind of picture; convert it to PNG", name);
  const FfmpegOwned<AVCodecContext> codec(Ffmpeg().avcodec_alloc_context3(decoder));
  const FfmpegOwned<AVPacket> packet(Ffmpeg().av_packet_alloc());
  FfmpegOwned<AVFrame> frame(Ffmpeg().av_frame_alloc());
  codec->thread_count = 1;
  constexpr double kAligned = 64;  // alignment of the library's rows
  codec->max_pixels = static_cast<std::int64_t>((claimed->width + kAligned) * claimed->height);
  int status = Ffmpeg().avcodec_open2(codec.get(), decoder, nullptr);
  if (status >= 0) status = Ffmpeg().av_new_packet(packet.get(), static_cast<int>(bytes.size()));
  if (status >= 0) {
    std::memcpy(packet->data, bytes.data(), bytes.size());
    status = Ffmpeg().avcodec_send_packet(codec.get(), packet.get());
  }
  if (status >= 0) status = Ffmpeg().avcodec_receive_frame(codec.get(), frame.get());
  if (status < 0) RefuseDamagedPicture(name, FfmpegErrorText(status));
  if (cv::Size2d(frame->width, frame->height) != *claimed)
    RefuseDamagedPicture(name, "its header can be read in two ways");
  return frame;
}

// Converts a frame to another layout, without any loss from a layout of the same channels and bits.
cv::Mat Scaled(const AVFrame& frame, AVPixelFormat wanted, int type, const std::string& name) {
  const FfmpegOwned<SwsContext> scaler(
      Ffmpeg().sws_getContext(frame.width, frame.height, static_cast<AVPixelFormat>(frame.format),
                              frame.width, frame.height, wanted, SWS_POINT, nullptr, nullptr, nullptr));
  if (!scaler) RefuseDamagedPicture(name, "its layout is not known");
  cv::Mat pixels(frame.height, frame.width, type);
  std::uint8_t* const to[4] = {pixels.data};
  const int line_bytes[4] = {static_cast<int>(pixels.step)};
  Ffmpeg().sws_scale(scaler.get(), frame.data, frame.linesize, 0, frame.height, to, line_bytes);
  return pixels;
}

StoredPicture FromFrame(const AVFrame& frame, const std::string& name) {
  constexpr int kByte = 8;
  const AVPixFmtDescriptor* layout = Ffmpeg().av_pix_fmt_desc_get(static_cast<AVPixelFormat>(frame.format));
  StoredPicture picture;
  switch (frame.format) {
    case AV_PIX_FMT_GRAY8:
      picture.pixels = Scaled(frame, AV_PIX_FMT_GRAY8, CV_8UC1, name);
      break;
    case AV_PIX_FMT_GRAY16BE:
    case AV_PIX_FMT_GRAY16LE:
      picture.pixels = Scaled(frame, AV_PIX_FMT_GRAY16LE, CV_16UC1, name);
      break;
    case AV_PIX_FMT_RGB48BE:
    case AV_PIX_FMT_RGB48LE:
      picture.pixels = Scaled(frame, AV_PIX_FMT_BGR48LE, CV_16UC3, name);
      break;
    case AV_PIX_FMT_BGRA:
      TakePixels(Scaled(frame, AV_PIX_FMT_BGRA, CV_8UC4, name), picture);
      break;
    default:
      if (!layout || layout->comp[0].depth > kByte)
        throw Error("{}: its layout of pixels is not read; convert it to PNG or TIFF", name);
      picture.pixels = Scaled(frame, AV_PIX_FMT_BGR24, CV_8UC3, name);
  }
  return picture;
}

// A comment ends a number, as Netpbm reads its files; FFmpeg would take it for a part of the number, and gets
// a header without it.
std::string WithoutComments(std::string_view bytes, int numbers, const std::string& name) {
  std::string head(bytes.substr(0, 2));
  std::size_t at = 2;
  const auto next = [&]() -> char {  // a comment reads as its line's end
    if (at < bytes.size() && bytes[at] == '#') at = bytes.find_first_of("\r\n", at);
    if (at >= bytes.size()) RefuseDamagedPicture(name, "its header");
    return bytes[at++];
  };
  for (int i = 0; i < numbers; ++i) {
    char c = next();
    while (std::isspace(static_cast<unsigned char>(c)) != 0) c = next();
    head += ' ';
    for (; std::isdigit(static_cast<unsigned char>(c)) != 0; c = next()) head += c;
    if (std::isspace(static_cast<unsigned char>(c)) == 0) RefuseDamagedPicture(name, "its header");
  }
  return head + "\n" + std::string(bytes.substr(at));
}

// The header has the kind, width, height, and a number whose sign says the byte order; then rows follow from
// the last to the first, which FFmpeg's decoder does not flip.
StoredPicture ReadPfm(std::string_view bytes, const std::string& name) {
  std::istringstream head{std::string(bytes.substr(0, 256))};
  std::string kind;
  int width = 0, height = 0;
  double scale = 0;
  if (!(head >> kind >> width >> height >> scale) || width <= 0 || height <= 0 || scale == 0)
    RefuseDamagedPicture(name, "its header");
  const auto pixels_at = static_cast<std::size_t>(head.tellg()) + 1;
  cv::Mat rows(height, width, kind == "PF" ? CV_32FC3 : CV_32FC1);
  const std::size_t size = rows.total() * rows.elemSize();
  if (bytes.size() < pixels_at || bytes.size() - pixels_at < size)
    RefuseDamagedPicture(name, "its pixels end too early");
  std::memcpy(rows.data, bytes.data() + pixels_at, size);
  if (scale > 0)
    for (std::size_t i = 0; i < size; i += 4) std::reverse(rows.data + i, rows.data + i + 4);
  StoredPicture picture;
  cv::flip(rows, picture.pixels, 0);
  if (rows.channels() == 3) cv::cvtColor(picture.pixels, picture.pixels, cv::COLOR_RGB2BGR);
  CheckFloatNumbers(picture);
  return picture;
}

// Light was multiplied by every EXPOSURE of the header; PRIMARIES are x and y of red, green, blue and white.
void ApplyRadianceHeader(std::string_view header, StoredPicture& picture) {
  std::istringstream lines{std::string(header)};
  double exposure = 1;
  for (std::string line; std::getline(lines, line);) {
    const std::size_t equals = line.find('=');
    if (equals == std::string::npos) continue;
    std::istringstream values(line.substr(equals + 1));
    if (line.starts_with("EXPOSURE")) {
      double factor = 1;
      if (values >> factor && factor > 0) exposure *= factor;
    }
    Primaries xy{};
    if (line.starts_with("PRIMARIES") &&
        (values >> xy[0] >> xy[1] >> xy[2] >> xy[3] >> xy[4] >> xy[5] >> xy[6] >> xy[7]))
      ConvertToSrgb({.primaries = xy, .exponent = 1.0}, picture);
  }
  if (exposure == 1) return;
  picture.pixels /= exposure;
  picture.notes.push_back(
      {fmt::format("its light was multiplied by {:g}", exposure), ", which is taken back"});
}

// Returns whether coded rows reach their end, which the library does not tell: it fills missing data with
// zeros. Rows of which each channel is coded by runs begin with 2, 2 and the width.
bool RadianceIsWhole(std::string_view bytes, std::size_t pixels_at, int width, int height) {
  const auto byte = [&](std::size_t at) {
    return static_cast<unsigned>(static_cast<std::uint8_t>(bytes[at]));
  };
  constexpr std::size_t kPixelBytes = 4;
  const auto columns = static_cast<std::size_t>(width);
  std::size_t at = pixels_at;
  for (int y = 0; y < height; ++y) {
    if (at + kPixelBytes > bytes.size()) return false;
    const bool has_runs = byte(at) == 2 && byte(at + 1) == 2 && (byte(at + 2) << 8 | byte(at + 3)) == columns;
    if (!has_runs)
      return y == 0 && bytes.size() - at >= columns * kPixelBytes * static_cast<std::size_t>(height);
    at += kPixelBytes;
    for (std::size_t done = 0; done < columns * kPixelBytes;) {
      if (at >= bytes.size()) return false;
      constexpr unsigned kRun = 128;
      const unsigned count = byte(at);
      if (count == 0) return false;
      at += count > kRun ? 2 : 1 + count;
      done += count > kRun ? count - kRun : count;
    }
    if (at > bytes.size()) return false;
  }
  return true;
}

// Returns whether the primaries and exponents of a calibrated BMP are those of sRGB, or missing (zero).
// Exponents stand for the curve or for its inverse, depending on the program.
bool IsNearSrgb(std::string_view bytes) {
  constexpr std::size_t kEndpointsAt = 74, kExponentsAt = 110;
  const auto number = [&](std::size_t at) {
    std::int32_t value = 0;
    if (at + sizeof value <= bytes.size()) std::memcpy(&value, bytes.data() + at, sizeof value);
    return static_cast<double>(value);
  };
  constexpr double kSame = 0.01, kOne = 1 << 16, kSrgbExponent = 2.2, kNear = 0.1;
  for (std::size_t c = 0; c < 3; ++c) {
    const std::size_t at = kEndpointsAt + 12 * c;
    const double x = number(at), y = number(at + 4), sum = x + y + number(at + 8);
    if (sum != 0 && (std::abs(x / sum - kSrgbPrimaries[2 * c]) > kSame ||
                     std::abs(y / sum - kSrgbPrimaries[2 * c + 1]) > kSame))
      return false;
    const double exponent = number(kExponentsAt + 4 * c) / kOne;
    if (exponent != 0 && std::abs(exponent - kSrgbExponent) > kNear &&
        std::abs(1 / exponent - kSrgbExponent) > kNear)
      return false;
  }
  return true;
}

}  // namespace

StoredPicture ReadBmp(std::string_view bytes, const std::string& name) {
  // The decoder fills missing data of run-coded rows with zeros: the header says how many bytes there are.
  const auto number = [&](std::size_t at) {
    std::uint32_t value = 0;
    if (at + sizeof value <= bytes.size()) std::memcpy(&value, bytes.data() + at, sizeof value);
    return std::uint64_t{value};
  };
  constexpr std::size_t kFileBytesAt = 2, kPixelsAt = 10, kHeaderBytesAt = 14, kCodingAt = 30,
                        kPixelBytesAt = 34;
  constexpr std::uint64_t kWindowsHeader = 40, kRuns8 = 1, kRuns4 = 2;
  const bool has_runs = number(kHeaderBytesAt) >= kWindowsHeader &&
                        (number(kCodingAt) == kRuns8 || number(kCodingAt) == kRuns4);
  if (has_runs && std::max(number(kFileBytesAt), number(kPixelsAt) + number(kPixelBytesAt)) > bytes.size())
    RefuseDamagedPicture(name, "its pixels end too early");
  StoredPicture picture = FromFrame(*DecodeOne(AV_CODEC_ID_BMP, bytes, name), name);
  // Version 5 of the header has a profile in the file, whose place counts from the header.
  constexpr std::size_t kSpaceAt = 70, kProfileAt = 126, kProfileBytesAt = 130;
  constexpr std::uint64_t kVersion5 = 124, kEmbedded = 0x4D424544;  // MBED
  if (const std::uint64_t at = kHeaderBytesAt + number(kProfileAt);
      number(kHeaderBytesAt) >= kVersion5 && number(kSpaceAt) == kEmbedded && at < bytes.size())
    ConvertToSrgb({.icc = std::string(bytes.substr(at, number(kProfileBytesAt)))}, picture);
  constexpr std::uint64_t kVersion4 = 108, kCalibrated = 0;
  if (number(kHeaderBytesAt) >= kVersion4 && number(kSpaceAt) == kCalibrated && !IsNearSrgb(bytes))
    picture.warnings.emplace_back(
        "its header says primaries or a curve that are not those of sRGB, which is not read of BMP: its "
        "colours are taken for sRGB");
  return picture;
}

StoredPicture ReadNetpbm(std::string_view bytes, const std::string& name) {
  const char kind = bytes.size() > 1 ? bytes[1] : '0';
  if (kind == 'F' || kind == 'f') return ReadPfm(bytes, name);
  const AVCodecID codec = kind == '1' || kind == '4'   ? AV_CODEC_ID_PBM
                          : kind == '2' || kind == '5' ? AV_CODEC_ID_PGM
                                                       : AV_CODEC_ID_PPM;
  const int numbers = codec == AV_CODEC_ID_PBM ? 2 : 3;
  const bool has_comments = bytes.substr(0, kMostOfHead).find('#') != std::string_view::npos;
  return FromFrame(*DecodeOne(codec, has_comments ? WithoutComments(bytes, numbers, name) : bytes, name),
                   name);
}

StoredPicture ReadRadiance(std::string_view bytes, const std::string& name) {
  // An empty line ends the header; the line of the size follows.
  const std::size_t size_at = bytes.find("\n\n");
  const std::size_t line_end = size_at == std::string_view::npos ? size_at : bytes.find('\n', size_at + 2);
  std::istringstream stream{std::string(bytes.substr(0, kMostOfHead))};
  const auto claimed = ClaimedSize(stream);
  // Checked before the library, which loops endlessly in some damaged rows.
  if (line_end == std::string_view::npos || !claimed ||
      !RadianceIsWhole(bytes, line_end + 1, static_cast<int>(claimed->width),
                       static_cast<int>(claimed->height)))
    RefuseDamagedPicture(name, "its pixels end too early, or have the old coding by runs");
  int width = 0, height = 0, channels = 0;
  constexpr int kColors = 3;
  const std::unique_ptr<float, void (*)(void*)> rgb(
      stbi_loadf_from_memory(reinterpret_cast<const stbi_uc*>(bytes.data()), static_cast<int>(bytes.size()),
                             &width, &height, &channels, kColors),
      stbi_image_free);
  if (!rgb) RefuseDamagedPicture(name, stbi_failure_reason());
  if (cv::Size2d(width, height) != *claimed) RefuseDamagedPicture(name, "its header can be read in two ways");
  StoredPicture picture;
  cv::cvtColor(cv::Mat(height, width, CV_32FC3, rgb.get()), picture.pixels, cv::COLOR_RGB2BGR);
  CheckFloatNumbers(picture);
  ApplyRadianceHeader(bytes.substr(0, size_at), picture);
  return picture;
}

}  // namespace ulf
