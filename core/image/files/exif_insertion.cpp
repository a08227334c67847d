#include "core/image/files/exif_insertion.h"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "core/base/binary_file.h"

namespace ulf {
namespace {

constexpr std::string_view kExifMark("Exif\0\0", 6), kPngMark("\x89PNG\r\n\x1a\n", 8), kJpegMark("\xff\xd8");

std::string BigEndianBytes(std::uint32_t number, int count) {
  std::string bytes;
  for (int i = count - 1; i >= 0; --i) bytes += static_cast<char>((number >> (8 * i)) & 0xFF);
  return bytes;
}

// The checksum of PNG's chunks (ISO 15948, annex D).
std::uint32_t CrcOf(std::string_view bytes) {
  constexpr std::uint32_t kPolynomial = 0xEDB88320;
  std::uint32_t crc = 0xFFFFFFFF;
  for (const char c : bytes) {
    crc ^= static_cast<unsigned char>(c);
    for (int bit = 0; bit < 8; ++bit) crc = (crc & 1) ? (crc >> 1) ^ kPolynomial : crc >> 1;
  }
  return ~crc;
}

// A part of a file that holds Exif data, or where it belongs.
struct ExifPlace {
  std::size_t at = 0, size = 0;  // of the segment or chunk; size 0: none is there
  std::string block;             // as of ReadExif(); empty if none is there
};

// Looks at the segments before the picture's data. A new one follows JFIF's, which must be the first.
std::optional<ExifPlace> PlaceInJpeg(const std::string& jpeg) {
  constexpr unsigned char kJfif = 0xE0, kApp1 = 0xE1, kScan = 0xDA, kFill = 0xFF;
  ExifPlace place{.at = kJpegMark.size(), .size = 0, .block = {}};
  for (std::size_t at = kJpegMark.size(); at + 4 <= jpeg.size();) {
    const auto marker = static_cast<unsigned char>(jpeg[at + 1]);
    if (marker == kFill) {
      ++at;
      continue;
    }
    const std::size_t size = 2 + BigEndian(std::string_view(jpeg).substr(at + 2, 2));
    if (jpeg[at] != '\xff' || at + size > jpeg.size()) return std::nullopt;
    if (marker == kScan) return place;
    if (marker == kApp1 && jpeg.compare(at + 4, kExifMark.size(), kExifMark) == 0)
      return ExifPlace{at, size, jpeg.substr(at + 4, size - 4)};
    if (marker == kJfif && at == kJpegMark.size()) place.at = at + size;
    at += size;
  }
  return std::nullopt;
}

// A new chunk follows the header.
std::optional<ExifPlace> PlaceInPng(const std::string& png) {
  constexpr std::size_t kFrame = 12;  // length, name and checksum
  ExifPlace place;
  for (std::size_t at = kPngMark.size(); at + kFrame <= png.size();) {
    const std::size_t size = kFrame + BigEndian(std::string_view(png).substr(at, 4));
    if (at + size > png.size()) return std::nullopt;
    if (png.compare(at + 4, 4, "eXIf") == 0)
      return ExifPlace{at, size, std::string(kExifMark) + png.substr(at + 8, size - kFrame)};
    if (place.at == 0) place.at = at + size;
    at += size;
  }
  return place;
}

bool SaysAlready(const std::string& block, const ExifFacts& facts) {
  if (block.empty()) return false;
  const ExifFacts there = ReadExif(block);
  constexpr double kSame = 1e-6;
  const auto has = [](const std::optional<double>& wanted, const std::optional<double>& found) {
    return !wanted || (found && std::abs(*found / *wanted - 1) < kSame);
  };
  const auto says = [](const std::string& wanted, const std::string& found) {
    return wanted.empty() || wanted == found;
  };
  return has(facts.exposure_s, there.exposure_s) && has(facts.f_number, there.f_number) &&
         has(facts.iso, there.iso) && has(facts.focal_mm, there.focal_mm) && says(facts.lens, there.lens) &&
         says(facts.maker, there.maker) && says(facts.model, there.model);
}

std::string JpegSegment(const std::string& block) {
  return "\xff\xe1" + BigEndianBytes(static_cast<std::uint32_t>(block.size() + 2), 2) + block;
}

std::string PngChunk(const std::string& block) {
  const std::string named = "eXIf" + block.substr(kExifMark.size());
  return BigEndianBytes(static_cast<std::uint32_t>(named.size() - 4), 4) + named +
         BigEndianBytes(CrcOf(named), 4);
}

std::optional<ExifPlace> PlaceIn(const std::string& picture) {
  if (picture.starts_with(kJpegMark)) return PlaceInJpeg(picture);
  return picture.starts_with(kPngMark) ? PlaceInPng(picture) : std::nullopt;
}

}  // namespace

std::optional<std::string> WithExif(const std::string& picture, const ExifFacts& facts) {
  constexpr std::size_t kMostInSegment = 65533;
  const std::optional<ExifPlace> place = PlaceIn(picture);
  if (!place) return std::nullopt;
  if (SaysAlready(place->block, facts)) return picture;
  const std::string block = ExifBlock(facts, place->block);
  const bool is_jpeg = picture.starts_with(kJpegMark);
  if (is_jpeg && block.size() > kMostInSegment) return std::nullopt;
  return std::string(picture).replace(place->at, place->size, is_jpeg ? JpegSegment(block) : PngChunk(block));
}

ExifFacts ExifOfPicture(const std::string& picture) {
  const std::optional<ExifPlace> place = PlaceIn(picture);
  return place && !place->block.empty() ? ReadExif(place->block) : ExifFacts{};
}

}  // namespace ulf
