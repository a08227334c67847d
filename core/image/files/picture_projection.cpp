#include "core/image/files/picture_projection.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <set>

#include "core/base/binary_file.h"
#include "core/base/error.h"
#include "core/base/lowercase.h"
#include "core/image/files/exif.h"

namespace ulf {
namespace {

// Returns attributes and elements with text, by their names without the namespace; values are in lower case.
// Text, comments and other values define no names.
std::map<std::string, std::string> PropertiesOf(std::string_view xmp) {
  constexpr std::string_view kSpaces = " \t\r\n";
  std::map<std::string, std::string> properties;
  const auto keep = [&](std::string_view name, std::string_view value) {
    value = value.substr(std::min(value.find_first_not_of(kSpaces), value.size()));
    value = value.substr(0, value.find_last_not_of(kSpaces) + 1);
    if (!value.empty()) properties.emplace(name.substr(name.rfind(':') + 1), Lowercase(ExifText(value)));
  };
  const auto next = [&](std::string_view any_of, std::size_t at) {
    return std::min(xmp.find_first_of(any_of, at), xmp.size());
  };
  const auto behind_spaces = [&](std::size_t at) {
    return std::min(xmp.find_first_not_of(kSpaces, at), xmp.size());
  };
  for (std::size_t at = xmp.find('<'); at < xmp.size(); at = xmp.find('<', at)) {
    if (const bool is_comment = xmp.substr(at).starts_with("<!--");
        is_comment || xmp.substr(at).starts_with("<![CDATA[")) {
      at = xmp.find(is_comment ? "-->" : "]]>", at);
      continue;
    }
    const std::size_t name_at = at + 1;
    at = next(" \t\r\n/>", name_at);
    const std::string_view element = xmp.substr(name_at, at - name_at);
    for (at = behind_spaces(at); at < xmp.size() && xmp[at] != '>'; at = behind_spaces(at)) {
      const std::size_t begin = at;
      at = next(" \t\r\n=/>", begin);
      const std::string_view attribute = xmp.substr(begin, at - begin);
      if (at == begin) ++at;
      const std::size_t equals = behind_spaces(at), quote = behind_spaces(equals + 1);
      if (quote >= xmp.size() || xmp[equals] != '=' || (xmp[quote] != '"' && xmp[quote] != '\'')) continue;
      at = std::min(xmp.find(xmp[quote], quote + 1), xmp.size() - 1) + 1;
      keep(attribute, xmp.substr(quote + 1, at - quote - 2));
    }
    if (at < xmp.size()) keep(element, xmp.substr(at + 1, next("<", at) - at - 1));
  }
  return properties;
}

// Reads numbers of either byte order; none beyond the end.
struct SegmentNumbers {
  std::string_view bytes;
  bool is_little = false;

  std::optional<std::uint32_t> At(std::size_t place, std::size_t count) const {
    if (place > bytes.size() || bytes.size() - place < count) return std::nullopt;
    const std::string_view number = bytes.substr(place, count);
    return static_cast<std::uint32_t>(is_little ? LittleEndian(number) : BigEndian(number));
  }
};

struct FurtherPictures {
  int count = 0;  // beside the first, without thumbnails
  bool is_stereo = false;
};

// Reads the index of CIPA DC-007: a TIFF directory whose entry 0xB002 has 16 bytes for each picture, which
// begin with its kind.
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

[[noreturn]] void RefuseStereo(const std::string& name, const std::string& what, StereoLayout layout) {
  throw Error("{}: is a stereo pair ({}), which no single lens made; {}", name, what,
              StereoPairRemedy(layout));
}

// The mark is followed by a length, then distance, flags, layout and type, a byte each.
void RequireNoJps(std::string_view segment, const std::string& name) {
  constexpr std::size_t kLayoutAt = 12, kTypeAt = 13;
  constexpr char kSideBySide = 2, kOverUnder = 3, kAnaglyph = 4, kStereo = 1;
  if (segment.size() <= kTypeAt || segment[kTypeAt] != kStereo) return;
  const char layout = segment[kLayoutAt];
  RefuseStereo(name,
               layout == kOverUnder  ? "JPS, one above the other"
               : layout == kAnaglyph ? "JPS, an anaglyph"
                                     : "JPS",
               layout == kSideBySide  ? StereoLayout::kSideBySide
               : layout == kOverUnder ? StereoLayout::kOverUnder
                                      : StereoLayout::kOther);
}

}  // namespace

std::string PanoramaRemedy(bool is_whole_sphere, const char* out) {
  return is_whole_sphere ? fmt::format(
                               "make perspective pictures of it, for instance with 'ffmpeg -i IN -vf "
                               "v360=e:flat:h_fov=90:v_fov=90:w=1500:h=1500:yaw=0 {}'",
                               out)
                         : "make perspective pictures of it with a program that knows its projection, such "
                           "as Hugin, or give the photographs that it was made of";
}

std::string StereoPairRemedy(StereoLayout layout) {
  if (layout == StereoLayout::kOther) return "give the pictures of one eye";
  return fmt::format("give the pictures of one eye, for instance by 'ffmpeg -i IN -vf crop={}:0:0 OUT'",
                     layout == StereoLayout::kSideBySide ? "iw/2:ih" : "iw:ih/2");
}

void RequireOneLens(std::string_view xmp, const std::string& name) {
  static const std::set<std::string> kOfLenses = {"perspective", "rectilinear", "fisheye", "planar"};
  const auto properties = PropertiesOf(xmp);
  const auto value = [&](const char* property) {
    const auto found = properties.find(property);
    return found == properties.end() ? std::string() : found->second;
  };
  const std::string projection = value("ProjectionType"), stereo = value("StereoMode");
  const bool is_whole = projection == "equirectangular" &&
                        value("CroppedAreaImageWidthPixels") == value("FullPanoWidthPixels") &&
                        value("CroppedAreaImageHeightPixels") == value("FullPanoHeightPixels");
  if (!projection.empty() && !kOfLenses.contains(projection))
    throw Error("{}: is a panorama (its XMP says ProjectionType {}), which no lens made; {}", name,
                projection, PanoramaRemedy(is_whole));
  if (projection.empty() && value("UsePanoramaViewer") == "true")
    throw Error("{}: is a panorama (its XMP says UsePanoramaViewer), which no lens made; {}", name,
                PanoramaRemedy(false));
  if (!stereo.empty() && stereo != "mono" && stereo != "none")
    RefuseStereo(name, fmt::format("its XMP says StereoMode {}", stereo),
                 stereo == "left-right"   ? StereoLayout::kSideBySide
                 : stereo == "top-bottom" ? StereoLayout::kOverUnder
                                          : StereoLayout::kOther);
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
    if (jpeg[at] != '\xFF' || *marker == 0xFF) {  // fill bytes before a marker
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
        picture.remarks.push_back(
            fmt::format("it holds {} pictures, of which the first is taken", further.count + 1));
    }
    at += 2 + *size;
  }
}

}  // namespace ulf
