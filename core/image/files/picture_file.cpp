#include "core/image/files/picture_file.h"

#include <spdlog/spdlog.h>

#include <fstream>
#include <mutex>
#include <opencv2/imgproc.hpp>
#include <set>
#include <system_error>

#include "core/base/atomic_file.h"
#include "core/base/binary_file.h"
#include "core/base/error.h"
#include "core/base/lowercase.h"
#include "core/image/files/exr_file.h"
#include "core/image/files/image_header.h"
#include "core/image/files/jpeg_codec.h"
#include "core/image/files/picture_codecs.h"
#include "core/image/files/picture_end.h"
#include "core/image/files/picture_kind.h"
#include "core/image/files/png_picture.h"
#include "core/image/files/raw_file.h"

namespace ulf {

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

// Checks before a decoder allocates the memory that the file claims.
void RequireRoomFor(const std::string& path, PictureKind kind) {
  const std::uintmax_t bytes = std::filesystem::file_size(path);
  constexpr double kBytesOfPixel =
      6;  // for the largest Netpbm; Radiance's floats need twice that, the others half
  if (kind == PictureKind::kNetpbm || kind == PictureKind::kRadiance || kind == PictureKind::kBmp ||
      kind == PictureKind::kWebp) {
    std::ifstream file(path, std::ios::binary);
    const auto size = ClaimedSize(file);
    constexpr double kMostPx = 1 << 20;
    if (!size || !(size->width >= 1 && size->height >= 1 && size->width < kMostPx && size->height < kMostPx))
      throw Error(
          "{}: says no size that a picture can have; it is damaged: copy it again from its source (of a "
          "light field: ulf repair DIR)",
          path);
    RequirePixelsOfFile(path, bytes, size->area(), kBytesOfPixel);
  } else if (kind != PictureKind::kExr && kind != PictureKind::kTiff) {
    const auto header = ReadImageHeader(path);
    if (!header)
      throw Error(
          "{}: its header is damaged; copy it again from its source (of a light field: ulf repair DIR)",
          path);
    RequirePixelsOfFile(path, bytes, static_cast<double>(header->width) * static_cast<double>(header->height),
                        header->channels * header->bits / 8.0);
  }
}

StoredPicture Decoded(const std::string& path) {
  const PictureKind kind = KindOfPicture(path);
  if (!IsRead(kind)) throw Error("{}: cannot be decoded as an image: it is {}", path, WordsOf(kind));
  RequireRoomFor(path, kind);
  switch (kind) {
    case PictureKind::kPng:
      return ReadPng(ReadWholeFile(path), path);
    case PictureKind::kJpeg:
      return ReadJpeg(ReadWholeFile(path), path);
    case PictureKind::kTiff:
      return ReadTiff(path);
    case PictureKind::kExr:
      return ReadExrPicture(path);
    case PictureKind::kWebp:
      return ReadWebp(ReadWholeFile(path), path);
    case PictureKind::kBmp:
      return ReadBmp(ReadWholeFile(path), path);
    case PictureKind::kNetpbm:
      return ReadNetpbm(ReadWholeFile(path), path);
    default:
      return ReadRadiance(ReadWholeFile(path), path);
  }
}

}  // namespace

StoredPicture ReadPicture(const std::string& path) {
  RequireWholeFile(path);
  return Decoded(path);
}

void LogWarnings(const std::string& path, const StoredPicture& picture) {
  static std::mutex mutex;
  static std::set<std::string> said;
  const std::lock_guard lock(mutex);
  for (const std::string& warning : picture.warnings)
    if (said.insert(WithoutNumbers(warning)).second)
      spdlog::warn("{}: {} (said once, others may be like it)", path, warning);
}

cv::Mat ReadImageFile(const std::string& path) {
  if (IsRawFile(path)) {
    RequireWholeFile(path);
    return ReadRawFile(path);
  }
  const StoredPicture picture = ReadPicture(path);
  LogWarnings(path, picture);
  return picture.pixels;
}

Transfer TransferOfFile(const std::filesystem::path& path) {
  if (IsRawFile(path)) return Transfer::kLinear;
  switch (KindOfPicture(path)) {
    case PictureKind::kExr:
    case PictureKind::kRadiance:
      return Transfer::kLinear;
    case PictureKind::kTiff: {
      const auto header = ReadImageHeader(path.string());
      return header && header->is_float ? Transfer::kLinear : Transfer::kSrgb;
    }
    case PictureKind::kNetpbm: {
      char kind[2] = {};
      std::ifstream(path, std::ios::binary).read(kind, sizeof kind);
      return kind[1] == 'F' || kind[1] == 'f' ? Transfer::kLinear : Transfer::kSrgb;
    }
    default:
      return Transfer::kSrgb;
  }
}

bool HasAlphaChannel(const std::filesystem::path& path) {
  if (IsRawFile(path)) return false;
  switch (KindOfPicture(path)) {
    case PictureKind::kPng:
    case PictureKind::kTiff: {
      const auto header = ReadImageHeader(path.string());
      return header && header->alpha;
    }
    case PictureKind::kExr:
      try {
        return HasExrAlpha(path.string());
      } catch (const Error&) {
        return false;  // the reader reports it
      }
    case PictureKind::kWebp: {
      std::ifstream file(path, std::ios::binary);
      return WebpHasAlpha(BytesAt(file, 0, 256));
    }
    default:
      return false;
  }
}

cv::Mat ReadAlpha(const std::string& path) {
  if (IsRawFile(path)) return {};
  const cv::Mat alpha = ReadPicture(path).alpha;
  if (alpha.empty()) return {};
  return alpha >= (alpha.depth() == CV_16U ? 1 << 15 : alpha.depth() == CV_8U ? 128 : 0.5);
}

cv::Size ReadImageSize(const std::string& path) {
  constexpr std::int64_t kMostPx = 1 << 20;
  if (const auto header = ReadImageHeader(path);
      header && header->width <= kMostPx && header->height <= kMostPx)
    return {static_cast<int>(header->width), static_cast<int>(header->height)};
  return IsRawFile(path) ? ReadRawFacts(path).size : ReadImageFile(path).size();
}

bool HasImageEnding(const std::filesystem::path& path) {
  static const std::set<std::string> kEndings = {".png", ".jpg",  ".jpeg", ".jpe",  ".jfif", ".mpo",
                                                 ".tif", ".tiff", ".bmp",  ".webp", ".exr",  ".ppm",
                                                 ".pgm", ".pbm",  ".pnm",  ".pfm",  ".hdr"};
  return kEndings.contains(Lowercase(path.extension().string())) || IsRawFile(path);
}

std::optional<std::string> UnreadPicture(const std::filesystem::path& path) {
  const PictureKind kind = UnreadKindByEnding(path);
  return kind == PictureKind::kUnknown ? std::nullopt : std::optional(WordsOf(kind));
}

void WritePictureFile(const std::string& path, const cv::Mat& srgb8) {
  const std::string ending = Lowercase(std::filesystem::path(path).extension().string());
  constexpr int kWebpQuality = 95;
  std::string bytes;
  if (ending == ".png")
    bytes = PngBytes(srgb8);
  else if (ending == ".jpg" || ending == ".jpeg")
    bytes = JpegBytes(srgb8);
  else if (ending == ".webp")
    bytes = WebpBytes(srgb8, kWebpQuality);
  else
    throw Error("{}: give a picture's name, ending in .png or .jpg", path);
  WriteFileAtomically(path, bytes);
}

cv::Mat ReadOverBackground(const std::string& path, const cv::Vec3d& background) {
  if (!HasAlphaChannel(path)) return {};
  const StoredPicture picture = ReadPicture(path);
  const int depth = picture.pixels.depth();
  const double full = FullScale(depth);
  if (picture.alpha.empty() || cv::countNonZero(picture.alpha < full) == 0) return {};
  cv::Mat colors = picture.pixels, alpha;
  if (colors.channels() == 1) cv::cvtColor(picture.pixels, colors, cv::COLOR_GRAY2BGR);
  colors.convertTo(colors, CV_64F);
  picture.alpha.convertTo(alpha, CV_64F, 1 / full);
  cv::Mat over(colors.size(), CV_64FC3);
  for (int y = 0; y < colors.rows; ++y)
    for (int x = 0; x < colors.cols; ++x) {
      const auto& from = colors.at<cv::Vec3d>(y, x);
      const double opaque = alpha.at<double>(y, x);
      auto& to = over.at<cv::Vec3d>(y, x);
      for (int c = 0; c < 3; ++c) to[c] = opaque * from[c] + (1 - opaque) * full * background[c];
    }
  over.convertTo(over, depth);
  return over;
}

}  // namespace ulf
