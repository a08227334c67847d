#include "core/image/files/exr_header.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <string_view>
#include <system_error>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/image/files/image_header.h"

namespace ulf {
namespace {

struct PixelLayout {
  double width = 0, height = 0, tile_px = 0, bytes_of_pixel = 0;
};

// Reads a little-endian number, the byte order of every machine that ulf runs on.
template <typename Number>
Number NumberAt(std::string_view value, std::size_t at) {
  Number number{};
  std::memcpy(&number, value.data() + at, sizeof number);
  return number;
}

std::string_view TextAt(std::string_view value, std::size_t at) {
  return value.substr(at, value.find('\0', at) - at);
}

// Names end by a zero, each followed by type, flags and sampling; an empty name ends the list.
bool ReadChannels(std::string_view value, PixelLayout& layout) {
  constexpr std::size_t kBytesAfterName = 16;
  constexpr std::int32_t kHalf = 1;
  std::size_t at = 0;
  for (;;) {
    const std::string_view name = TextAt(value, at);
    at += name.size() + 1;
    if (at > value.size()) return false;
    if (name.empty()) return at == value.size();
    if (value.size() - at < kBytesAfterName) return false;
    layout.bytes_of_pixel += NumberAt<std::int32_t>(value, at) == kHalf ? 2 : 4;
    at += kBytesAfterName;
  }
}

bool AreStrings(std::string_view value) {
  while (value.size() >= sizeof(std::uint32_t)) {
    const auto length = NumberAt<std::uint32_t>(value, 0);
    value.remove_prefix(sizeof length);
    if (length > value.size()) return false;
    value.remove_prefix(length);
  }
  return value.empty();
}

bool IsPreview(std::string_view value) {
  constexpr std::size_t kSize = 2 * sizeof(std::uint32_t);
  if (value.size() < kSize) return false;
  const std::uint64_t width = NumberAt<std::uint32_t>(value, 0), height = NumberAt<std::uint32_t>(value, 4);
  const std::uint64_t pixels = (value.size() - kSize) / 4;
  return value.size() % 4 == 0 && (width == 0 || height <= pixels / width) && width * height == pixels;
}

// Returns false if the value's length differs from its type's.
bool ReadAttribute(std::string_view name, std::string_view type, std::string_view value,
                   PixelLayout& layout) {
  static const std::map<std::string_view, std::size_t> kBytesOfType = {{"box2f", 16},
                                                                       {"box2i", 16},
                                                                       {"chromaticities", 32},
                                                                       {"compression", 1},
                                                                       {"deepImageState", 1},
                                                                       {"double", 8},
                                                                       {"envmap", 1},
                                                                       {"float", 4},
                                                                       {"int", 4},
                                                                       {"keycode", 28},
                                                                       {"m33d", 72},
                                                                       {"m33f", 36},
                                                                       {"m44d", 128},
                                                                       {"m44f", 64},
                                                                       {"lineOrder", 1},
                                                                       {"rational", 8},
                                                                       {"timecode", 8},
                                                                       {"tiledesc", 9},
                                                                       {"v2d", 16},
                                                                       {"v2f", 8},
                                                                       {"v2i", 8},
                                                                       {"v3d", 24},
                                                                       {"v3f", 12},
                                                                       {"v3i", 12}};
  if (type == "chlist") return ReadChannels(value, layout);
  if (type == "preview") return IsPreview(value);
  if (type == "stringvector") return AreStrings(value);
  if (type == "floatvector") return value.size() % sizeof(float) == 0;
  if (type == "idmanifest") return value.size() >= sizeof(std::int32_t);
  const auto bytes = kBytesOfType.find(type);
  if (bytes == kBytesOfType.end()) return true;
  if (bytes->second != value.size()) return false;
  if (name == "dataWindow" && type == "box2i") {
    const auto corner = [&](std::size_t at) -> double { return NumberAt<std::int32_t>(value, 4 * at); };
    layout.width = corner(2) - corner(0) + 1;
    layout.height = corner(3) - corner(1) + 1;
  }
  if (type == "tiledesc")
    layout.tile_px =
        static_cast<double>(NumberAt<std::uint32_t>(value, 0)) * NumberAt<std::uint32_t>(value, 4);
  return true;
}

// The library allocates the lines or the tile of one compressed block, and a table of all blocks.
void RequireBlocks(const std::string& path, std::uint64_t file_bytes, const PixelLayout& layout) {
  constexpr double kMostPx = 1 << 20, kMostLinesOfBlock = 256, kBytesOfPlace = 8, kLevelsOfTiles = 4;
  if (std::max(layout.width, layout.height) > kMostPx)
    throw Error("{}: is {:.0f}x{:.0f}, which is no picture's size; write it again", path, layout.width,
                layout.height);
  const double lines_px = layout.width * std::max(layout.height, kMostLinesOfBlock);
  // Programs write one tile of 64 or 256 pixels for a small picture.
  constexpr double kTileOfAnyPicture_px = 4096.0 * 4096;
  if (layout.tile_px > std::max(lines_px, kTileOfAnyPicture_px))
    throw Error(
        "{}: has tiles of {:.0f} million pixels in a picture of {:.0f}x{:.0f}; it is damaged: copy it again "
        "from its source",
        path, 1e-6 * layout.tile_px, layout.width, layout.height);
  RequirePixelsOfFile(path, file_bytes, std::max(lines_px, layout.tile_px), layout.bytes_of_pixel);
  if (layout.tile_px > 0)
    RequirePixelsOfFile(path, file_bytes, layout.width * layout.height / layout.tile_px,
                        kLevelsOfTiles * kBytesOfPlace);
}

}  // namespace

void RefuseExr(const std::string& path, const char* why) {
  throw Error(
      "{}: the image is truncated or damaged ({}); copy it again from its source (of a light field: ulf "
      "repair DIR)",
      path, why);
}

void RequireExrHeader(const std::string& path) {
  RequireRegularFile(path);
  std::ifstream file(path, std::ios::binary);
  std::error_code unknown;
  const std::uintmax_t file_bytes = std::filesystem::file_size(path, unknown);
  std::array<char, 8> begin{};
  if (unknown || !file.read(begin.data(), begin.size()) || std::string_view(begin.data(), 4) != "v/1\x01")
    return;
  constexpr char kSeveralParts = 0x10;
  const bool has_parts = (begin[5] & kSeveralParts) != 0;
  const auto text = [&] {
    constexpr std::size_t kLongest = 255;
    std::string name;
    char c = 0;
    while (file.get(c) && c != '\0' && name.size() <= kLongest) name += c;
    if (!file || name.size() > kLongest) RefuseExr(path, "its header has no end");
    return name;
  };
  PixelLayout layout;
  for (bool follows_end = false;;) {
    const std::string name = text();
    if (name.empty()) {
      RequireBlocks(path, file_bytes, layout);
      if (!has_parts || follows_end) return;
      layout = {};
      follows_end = true;
      continue;
    }
    follows_end = false;
    const std::string type = text();
    std::uint32_t size = 0;
    if (!file.read(reinterpret_cast<char*>(&size), sizeof size) || size > file_bytes)
      RefuseExr(path, "an attribute of its header is longer than the file");
    std::string value(size, '\0');
    if (!file.read(value.data(), size)) RefuseExr(path, "an attribute of its header is longer than the file");
    if (!ReadAttribute(name, type, value, layout))
      RefuseExr(path, "an attribute of its header has another length than its type");
  }
}

}  // namespace ulf
