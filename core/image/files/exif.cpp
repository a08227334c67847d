#include "core/image/files/exif.h"

#include <libexif/exif-data.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <memory>
#include <numeric>

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

struct Unref {
  void operator()(ExifData* data) const { exif_data_unref(data); }
};
using ExifHandle = std::unique_ptr<ExifData, Unref>;

ExifHandle ExifOf(const std::string& jpeg) {
  return ExifHandle(exif_data_new_from_data(reinterpret_cast<const unsigned char*>(jpeg.data()),
                                            static_cast<unsigned>(jpeg.size())));
}

// Keeps what libexif does not know or would mend; new data if there are none.
ExifHandle ExifToChange(const std::string& jpeg) {
  ExifHandle data(exif_data_new());
  exif_data_unset_option(data.get(), EXIF_DATA_OPTION_IGNORE_UNKNOWN_TAGS);
  exif_data_unset_option(data.get(), EXIF_DATA_OPTION_FOLLOW_SPECIFICATION);
  exif_data_set_option(data.get(), EXIF_DATA_OPTION_DONT_CHANGE_MAKER_NOTE);
  exif_data_set_byte_order(data.get(), EXIF_BYTE_ORDER_INTEL);
  exif_data_load_data(data.get(), reinterpret_cast<const unsigned char*>(jpeg.data()),
                      static_cast<unsigned>(jpeg.size()));
  return data;
}

// Replaces an entry by one with `bytes` of value, which it returns for the caller to fill.
ExifEntry* NewEntry(ExifData* data, ExifIfd directory, ExifTag tag, ExifFormat format, unsigned components) {
  ExifContent* content = data->ifd[directory];
  if (ExifEntry* former = exif_content_get_entry(content, tag)) exif_content_remove_entry(content, former);
  ExifEntry* entry = exif_entry_new();
  const unsigned bytes = components * exif_format_get_size(format);
  entry->tag = tag;
  entry->format = format;
  entry->components = components;
  entry->size = bytes;
  entry->data = static_cast<unsigned char*>(std::calloc(bytes, 1));  // libexif frees it
  exif_content_add_entry(content, entry);
  exif_entry_unref(entry);
  return entry;
}

// A whole number over another: 1 over one where that is exact, as cameras write exposure times.
ExifRational RationalOf(double value) {
  constexpr double kMost = std::numeric_limits<std::uint32_t>::max(), kExact = 1e-7;
  if (const double over = std::round(1 / value); over <= kMost && std::abs(over * value - 1) < kExact)
    return {1, static_cast<ExifLong>(over)};
  double denominator = 1e9;
  while (value * denominator > kMost) denominator /= 10;
  const auto a = static_cast<std::uint32_t>(std::round(value * denominator)),
             b = static_cast<std::uint32_t>(denominator), common = std::gcd(a, b);
  return {a / common, b / common};
}

void SetRational(ExifData* data, ExifTag tag, const std::optional<double>& value) {
  if (!value || !(*value > 0)) return;
  ExifEntry* entry = NewEntry(data, EXIF_IFD_EXIF, tag, EXIF_FORMAT_RATIONAL, 1);
  exif_set_rational(entry->data, exif_data_get_byte_order(data), RationalOf(*value));
}

void SetText(ExifData* data, ExifIfd directory, ExifTag tag, const std::string& text) {
  if (text.empty()) return;
  ExifEntry* entry =
      NewEntry(data, directory, tag, EXIF_FORMAT_ASCII, static_cast<unsigned>(text.size()) + 1);
  std::memcpy(entry->data, text.data(), text.size());
}

// The field is a number of 16 bits.
void SetIso(ExifData* data, const std::optional<double>& iso) {
  constexpr double kMost = std::numeric_limits<std::uint16_t>::max();
  if (!iso || !(*iso > 0)) return;
  ExifEntry* entry = NewEntry(data, EXIF_IFD_EXIF, EXIF_TAG_ISO_SPEED_RATINGS, EXIF_FORMAT_SHORT, 1);
  exif_set_short(entry->data, exif_data_get_byte_order(data),
                 static_cast<ExifShort>(std::clamp(std::round(*iso), 1.0, kMost)));
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
  const ExifHandle data = ExifOf(jpeg);
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
  facts.maker = TextOf(data.get(), EXIF_IFD_0, EXIF_TAG_MAKE);
  facts.model = TextOf(data.get(), EXIF_IFD_0, EXIF_TAG_MODEL);
  return facts;
}

std::string ExifBlock(const ExifFacts& facts, const std::string& jpeg) {
  const ExifHandle data = ExifToChange(jpeg);
  SetRational(data.get(), EXIF_TAG_EXPOSURE_TIME, facts.exposure_s);
  SetRational(data.get(), EXIF_TAG_FNUMBER, facts.f_number);
  SetIso(data.get(), facts.iso);
  SetRational(data.get(), EXIF_TAG_FOCAL_LENGTH, facts.focal_mm);
  SetText(data.get(), EXIF_IFD_EXIF, EXIF_TAG_LENS_MODEL, facts.lens);
  SetText(data.get(), EXIF_IFD_0, EXIF_TAG_MAKE, facts.maker);
  SetText(data.get(), EXIF_IFD_0, EXIF_TAG_MODEL, facts.model);
  unsigned char* bytes = nullptr;
  unsigned size = 0;
  exif_data_save_data(data.get(), &bytes, &size);
  std::string block(reinterpret_cast<const char*>(bytes), size);
  std::free(bytes);
  return block;
}

}  // namespace ulf
