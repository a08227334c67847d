#include "core/image/files/exif.h"

#include <libexif/exif-data.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <fstream>
#include <memory>

#include "core/base/binary_file.h"

namespace ulf {
namespace {

std::optional<double> Number(ExifData* data, ExifIfd directory, ExifTag tag) {
  ExifEntry* entry = exif_content_get_entry(data->ifd[directory], tag);
  if (!entry || !entry->data || entry->components < 1) return std::nullopt;
  const ExifByteOrder order = exif_data_get_byte_order(data);
  switch (entry->format) {
    case EXIF_FORMAT_SHORT:
      return exif_get_short(entry->data, order);
    case EXIF_FORMAT_LONG:
      return exif_get_long(entry->data, order);
    case EXIF_FORMAT_RATIONAL: {
      const ExifRational ratio = exif_get_rational(entry->data, order);
      if (ratio.denominator == 0) return std::nullopt;
      return static_cast<double>(ratio.numerator) / ratio.denominator;
    }
    default:
      return std::nullopt;
  }
}

std::string TextOf(ExifData* data, ExifIfd directory, ExifTag tag) {
  const ExifEntry* entry = exif_content_get_entry(data->ifd[directory], tag);
  if (!entry || !entry->data || entry->format != EXIF_FORMAT_ASCII) return {};
  return ExifText({reinterpret_cast<const char*>(entry->data), entry->size});
}

std::optional<double> Positive(std::optional<double> number) {
  return number && *number > 0 ? number : std::nullopt;
}

}  // namespace

std::string ExifText(std::string_view bytes) {
  std::string text(bytes.substr(0, bytes.find('\0')));
  const auto is_plain = [](char c) { return c > ' ' && c <= '~'; };
  for (char& c : text)
    if (!is_plain(c)) c = c == ' ' ? ' ' : '?';
  text.erase(0, std::min(text.find_first_not_of(' '), text.size()));
  text.erase(text.find_last_not_of(' ') + 1);
  const auto says_something = [](unsigned char c) { return std::isalnum(c) != 0; };
  return std::ranges::any_of(text, says_something) ? text : std::string();
}

ExifFacts ReadExif(const std::string& jpeg) {
  struct Unref {
    void operator()(ExifData* data) const { exif_data_unref(data); }
  };
  const std::unique_ptr<ExifData, Unref> data(exif_data_new_from_data(
      reinterpret_cast<const unsigned char*>(jpeg.data()), static_cast<unsigned>(jpeg.size())));
  ExifFacts facts;
  if (!data) return facts;
  facts.exposure_s = Positive(Number(data.get(), EXIF_IFD_EXIF, EXIF_TAG_EXPOSURE_TIME));
  facts.f_number = Positive(Number(data.get(), EXIF_IFD_EXIF, EXIF_TAG_FNUMBER));
  facts.iso = Positive(Number(data.get(), EXIF_IFD_EXIF, EXIF_TAG_ISO_SPEED_RATINGS));
  facts.focal_mm = Positive(Number(data.get(), EXIF_IFD_EXIF, EXIF_TAG_FOCAL_LENGTH));
  facts.focal_35mm = Positive(Number(data.get(), EXIF_IFD_EXIF, EXIF_TAG_FOCAL_LENGTH_IN_35MM_FILM));
  constexpr double kLastOrientation = 8;
  if (const auto orientation = Number(data.get(), EXIF_IFD_0, EXIF_TAG_ORIENTATION);
      orientation && *orientation >= 1 && *orientation <= kLastOrientation)
    facts.orientation = static_cast<int>(*orientation);
  facts.taken = TextOf(data.get(), EXIF_IFD_EXIF, EXIF_TAG_DATE_TIME_ORIGINAL);
  if (const std::string parts = TextOf(data.get(), EXIF_IFD_EXIF, EXIF_TAG_SUB_SEC_TIME_ORIGINAL);
      !facts.taken.empty() && !parts.empty())
    facts.taken += "." + parts;
  constexpr double kUncalibrated = 65535;
  const bool is_uncalibrated = Number(data.get(), EXIF_IFD_EXIF, EXIF_TAG_COLOR_SPACE) == kUncalibrated;
  facts.is_adobe_rgb =
      TextOf(data.get(), EXIF_IFD_INTEROPERABILITY, EXIF_TAG_INTEROPERABILITY_INDEX) == "R03";
  facts.is_other_space = is_uncalibrated && !facts.is_adobe_rgb;
  facts.lens = TextOf(data.get(), EXIF_IFD_EXIF, EXIF_TAG_LENS_MODEL);
  facts.camera = TextOf(data.get(), EXIF_IFD_0, EXIF_TAG_MODEL);
  return facts;
}

ExifFacts ReadExifOfFile(const std::filesystem::path& file) {
  constexpr std::size_t kExifBytes = 1 << 17;  // a segment has at most half of it
  std::ifstream stream(file, std::ios::binary);
  const std::string head = BytesAt(stream, 0, kExifBytes);
  return head.starts_with("\xFF\xD8") ? ReadExif(head) : ExifFacts();
}

std::optional<double> FocalPx(const ExifFacts& exif, double width, double height) {
  if (!exif.focal_35mm) return std::nullopt;
  return *exif.focal_35mm / std::hypot(36.0, 24.0) * std::hypot(width, height);
}

}  // namespace ulf
