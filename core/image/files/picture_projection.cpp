#include "core/image/files/picture_projection.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <set>

#include "core/base/error.h"
#include "core/base/lowercase.h"
#include "core/image/files/jpeg_file.h"

namespace ulf {
namespace {

// The value of a property in whatever namespace, as an attribute or as an element, in lower case; empty: there is none.
std::string XmpValue(std::string_view xmp, const std::string& property) {
  const std::string wanted = ":" + property;
  for (std::size_t at = xmp.find(wanted); at != std::string_view::npos; at = xmp.find(wanted, at + 1)) {
    std::size_t begin = xmp.find_first_not_of(" \t\r\n", at + wanted.size());
    if (begin == std::string_view::npos) break;
    char end = '<';
    if (xmp[begin] == '=') {
      begin = xmp.find_first_of("\"'", begin);
      if (begin == std::string_view::npos) break;
      end = xmp[begin];
    } else if (xmp[begin] != '>') {
      continue;  // a longer name
    }
    std::string value = Lowercase(ExifText(xmp.substr(begin + 1, xmp.find(end, begin + 1) - begin - 1)));
    if (!value.empty()) return value;
  }
  return {};
}

// Numbers of either order of bytes; none beyond the end.
struct SegmentNumbers {
  std::string_view bytes;
  bool is_little = false;

  std::optional<std::uint32_t> At(std::size_t place, std::size_t count) const {
    if (place > bytes.size() || bytes.size() - place < count) return std::nullopt;
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < count; ++i)
      value = value << 8 | static_cast<std::uint8_t>(bytes[place + (is_little ? count - 1 - i : i)]);
    return value;
  }
};

struct FurtherPictures {
  int count = 0;  // beside the first, thumbnails aside
  bool is_stereo = false;
};

// Of the index of CIPA DC-007: a TIFF directory whose entry 0xB002 has 16 bytes for each picture, which begin with its kind.
FurtherPictures FurtherPicturesIn(std::string_view index) {
  const SegmentNumbers numbers{index, index.starts_with("II")};
  FurtherPictures further;
  const auto directory = numbers.At(4, 4);
  const auto entries = directory ? numbers.At(*directory, 2) : std::nullopt;
  constexpr std::size_t kEntryBytes = 12, kPictureBytes = 16;
  constexpr std::uint32_t kPictures = 0xB002, kKind = 0xFFFFFF, kDisparity = 0x020002;
  static const std::set<std::uint32_t> kThumbnails = {0x010001, 0x010002};
  for (std::size_t i = 0; entries && i < *entries; ++i) {
    const std::size_t entry = *directory + 2 + i * kEntryBytes;
    if (numbers.At(entry, 2) != kPictures) continue;
    const auto bytes = numbers.At(entry + 4, 4), place = numbers.At(entry + 8, 4);
    if (!bytes || !place) break;
    for (std::size_t at = 0; at + kPictureBytes <= *bytes; at += kPictureBytes) {
      const auto attributes = numbers.At(*place + at, 4);
      if (!attributes) break;
      const std::uint32_t kind = *attributes & kKind;
      further.is_stereo = further.is_stereo || kind == kDisparity;
      if (at > 0 && !kThumbnails.contains(kind)) ++further.count;
    }
  }
  return further;
}

[[noreturn]] void RefuseStereo(const std::string& name, const std::string& what) {
  throw Error("{}: is a stereo pair ({}), which no single lens made; {}", name, what, kFromStereoPair);
}

// Behind its mark: a length, then distance, flags, layout and type, a byte each.
void RequireNoJps(std::string_view segment, const std::string& name) {
  constexpr std::size_t kLayoutAt = 12, kTypeAt = 13;
  constexpr char kOverUnder = 3, kAnaglyph = 4, kStereo = 1;
  if (segment.size() <= kTypeAt || segment[kTypeAt] != kStereo) return;
  RefuseStereo(name, segment[kLayoutAt] == kOverUnder  ? "JPS, one above the other"
                     : segment[kLayoutAt] == kAnaglyph ? "JPS, an anaglyph"
                                                       : "JPS");
}

}  // namespace

void RequireOneLens(std::string_view xmp, const std::string& name) {
  static const std::set<std::string> kOfLenses = {"perspective", "rectilinear", "fisheye"};
  const std::string projection = XmpValue(xmp, "ProjectionType"), stereo = XmpValue(xmp, "StereoMode");
  if (!projection.empty() && !kOfLenses.contains(projection))
    throw Error("{}: is a panorama (its XMP says ProjectionType {}), which no lens made; {}", name,
                projection, kFromPanorama);
  if (projection.empty() && XmpValue(xmp, "UsePanoramaViewer") == "true")
    throw Error("{}: is a panorama (its XMP says UsePanoramaViewer), which no lens made; {}", name,
                kFromPanorama);
  if (!stereo.empty() && stereo != "mono" && stereo != "none")
    RefuseStereo(name, fmt::format("its XMP says StereoMode {}", stereo));
}

void WarnOfPixelAspect(double across, double down, StoredPicture& picture) {
  constexpr double kSquare = 0.02;  // of rounded numbers
  if (!(across > 0 && down > 0) || std::abs(std::log(across / down)) < kSquare) return;
  picture.warnings.push_back(fmt::format(
      "its pixels are not square by what it says ({:g} to {:g}): its lens needs two focal lengths "
      "that differ by that, which a guessed one has not",
      across, down));
}

void RequireOneLensOfJpeg(std::string_view jpeg, const std::string& name, StoredPicture& picture) {
  constexpr std::uint32_t kStartOfScan = 0xDA, kXmp = 0xE1, kIndex = 0xE2, kJps = 0xE3;
  constexpr std::string_view kXmpMark("http://ns.adobe.com/xap/1.0/\0", 29), kIndexMark("MPF\0", 4),
      kJpsMark("_JPSJPS_");
  const SegmentNumbers numbers{jpeg};
  for (std::size_t at = 2; const auto marker = numbers.At(at + 1, 1);) {
    if (jpeg[at] != '\xFF' || *marker == 0xFF) {  // bytes that stand before a marker and mean nothing
      ++at;
      continue;
    }
    if ((*marker >= 0xD0 && *marker <= 0xD8) || *marker <= 0x01) {  // without a length
      at += 2;
      continue;
    }
    const auto size = numbers.At(at + 2, 2);
    if (*marker == kStartOfScan || !size || *size < 2) return;
    const std::string_view content = jpeg.substr(std::min(at + 4, jpeg.size()), *size - 2);
    if (*marker == kXmp && content.starts_with(kXmpMark)) RequireOneLens(content, name);
    if (*marker == kJps && content.starts_with(kJpsMark)) RequireNoJps(content, name);
    if (*marker == kIndex && content.starts_with(kIndexMark)) {
      const FurtherPictures further = FurtherPicturesIn(content.substr(kIndexMark.size()));
      if (further.is_stereo)
        throw Error(
            "{}: is a stereo pair (MPO, of which each picture is for one eye); give the pictures of one eye "
            "as files of their own, for instance by 'djpeg IN | cjpeg -quality 95 > OUT.jpg'",
            name);
      if (further.count > 0)
        picture.notes.push_back(
            fmt::format("it holds {} pictures, of which the first is taken", further.count + 1));
    }
    at += 2 + *size;
  }
}

}  // namespace ulf
