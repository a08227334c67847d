#include "core/image/files/picture_codecs.h"

#include <webp/decode.h>
#include <webp/encode.h>

#include <cstdint>
#include <cstring>

#include "core/base/error.h"
#include "core/image/files/exif.h"
#include "core/image/files/picture_colors.h"
#include "core/image/files/picture_projection.h"

namespace ulf {
namespace {

const std::uint8_t* Data(std::string_view bytes) {
  return reinterpret_cast<const std::uint8_t*>(bytes.data());
}

// Returns the content of the chunk of this name; empty if there is none.
std::string_view ChunkOfWebp(std::string_view bytes, std::string_view name) {
  constexpr std::size_t kFirst = 12, kHead = 8;
  for (std::size_t at = kFirst; at + kHead <= bytes.size();) {
    std::uint32_t size = 0;
    std::memcpy(&size, bytes.data() + at + 4, sizeof size);
    if (size > bytes.size() - at - kHead) return {};
    if (bytes.substr(at, 4) == name) return bytes.substr(at + kHead, size);
    at += kHead + size + size % 2;
  }
  return {};
}

}  // namespace

StoredPicture ReadWebp(std::string_view bytes, const std::string& name) {
  WebPBitstreamFeatures features{};
  const bool is_known = WebPGetFeatures(Data(bytes), bytes.size(), &features) == VP8_STATUS_OK;
  if (is_known && features.has_animation != 0)
    throw Error("{}: is an animated WebP; extract its pictures, for instance with anim_dump", name);
  cv::Mat pixels;
  if (is_known) {
    const int channels = features.has_alpha != 0 ? 4 : 3;
    pixels.create(features.height, features.width, CV_8UC(channels));
    const std::size_t size = pixels.step * static_cast<std::size_t>(pixels.rows);
    const auto* decoded =
        channels == 4
            ? WebPDecodeBGRAInto(Data(bytes), bytes.size(), pixels.data, size, static_cast<int>(pixels.step))
            : WebPDecodeBGRInto(Data(bytes), bytes.size(), pixels.data, size, static_cast<int>(pixels.step));
    if (!decoded) pixels.release();
  }
  if (pixels.empty())
    throw Error(
        "{}: the image is truncated or damaged; copy it again from its source (of a light field: ulf repair "
        "DIR)",
        name);
  RequireOneLens(ChunkOfWebp(bytes, "XMP "), name);
  StoredPicture picture;
  TakePixels(pixels, picture);
  if (std::string exif(ChunkOfWebp(bytes, "EXIF")); !exif.empty()) {
    const std::string head("Exif\0\0", 6);
    NoteOrientation(ReadExif(exif.starts_with(head) ? exif : head + exif).orientation, picture);
  }
  if (const std::string_view icc = ChunkOfWebp(bytes, "ICCP"); !icc.empty())
    ConvertToSrgb({.icc = std::string(icc)}, picture);
  return picture;
}

std::optional<cv::Size2d> WebpSize(std::string_view begin) {
  WebPBitstreamFeatures features{};
  if (WebPGetFeatures(Data(begin), begin.size(), &features) != VP8_STATUS_OK) return std::nullopt;
  return cv::Size2d(features.width, features.height);
}

bool WebpHasAlpha(std::string_view begin) {
  WebPBitstreamFeatures features{};
  return WebPGetFeatures(Data(begin), begin.size(), &features) == VP8_STATUS_OK && features.has_alpha != 0;
}

std::string WebpBytes(const cv::Mat& pixels, int quality) {
  std::uint8_t* bytes = nullptr;
  const auto encode = pixels.channels() == 4 ? WebPEncodeBGRA : WebPEncodeBGR;
  std::size_t size = 0;
  if (pixels.type() == CV_8UC3 || pixels.type() == CV_8UC4)
    size = encode(pixels.data, pixels.cols, pixels.rows, static_cast<int>(pixels.step),
                  static_cast<float>(quality), &bytes);
  const std::string webp(reinterpret_cast<const char*>(bytes), size);
  WebPFree(bytes);
  if (webp.empty())
    throw Error("a picture of {}x{} with {} channels cannot be written as WebP", pixels.cols, pixels.rows,
                pixels.channels());
  return webp;
}

}  // namespace ulf
