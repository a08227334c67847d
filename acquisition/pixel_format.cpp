#include "acquisition/pixel_format.h"

#include <array>
#include <cstring>
#include <opencv2/imgproc.hpp>

#include "acquisition/error.h"

namespace ulf {
namespace {

using enum PixelPacking;

constexpr std::array kFormats = {
    PixelFormat{"Mono8", 0x01080001, 8},
    PixelFormat{"Mono10", 0x01100003, 10},
    PixelFormat{"Mono12", 0x01100005, 12},
    PixelFormat{"Mono14", 0x01100025, 14},
    PixelFormat{"Mono16", 0x01100007, 16},
    PixelFormat{"Mono10p", 0x010A0046, 10, 1, Mosaic::kNone, kLsbPacked},
    PixelFormat{"Mono12p", 0x010C0047, 12, 1, Mosaic::kNone, kLsbPacked},
    PixelFormat{"Mono10Packed", 0x010C0004, 10, 1, Mosaic::kNone, kGvspPacked},
    PixelFormat{"Mono12Packed", 0x010C0006, 12, 1, Mosaic::kNone, kGvspPacked},
    PixelFormat{"BayerGR8", 0x01080008, 8, 1, Mosaic::kGrbg},
    PixelFormat{"BayerRG8", 0x01080009, 8, 1, Mosaic::kRggb},
    PixelFormat{"BayerGB8", 0x0108000A, 8, 1, Mosaic::kGbrg},
    PixelFormat{"BayerBG8", 0x0108000B, 8, 1, Mosaic::kBggr},
    PixelFormat{"BayerGR10", 0x0110000C, 10, 1, Mosaic::kGrbg},
    PixelFormat{"BayerRG10", 0x0110000D, 10, 1, Mosaic::kRggb},
    PixelFormat{"BayerGB10", 0x0110000E, 10, 1, Mosaic::kGbrg},
    PixelFormat{"BayerBG10", 0x0110000F, 10, 1, Mosaic::kBggr},
    PixelFormat{"BayerGR12", 0x01100010, 12, 1, Mosaic::kGrbg},
    PixelFormat{"BayerRG12", 0x01100011, 12, 1, Mosaic::kRggb},
    PixelFormat{"BayerGB12", 0x01100012, 12, 1, Mosaic::kGbrg},
    PixelFormat{"BayerBG12", 0x01100013, 12, 1, Mosaic::kBggr},
    PixelFormat{"BayerGR16", 0x0110002E, 16, 1, Mosaic::kGrbg},
    PixelFormat{"BayerRG16", 0x0110002F, 16, 1, Mosaic::kRggb},
    PixelFormat{"BayerGB16", 0x01100030, 16, 1, Mosaic::kGbrg},
    PixelFormat{"BayerBG16", 0x01100031, 16, 1, Mosaic::kBggr},
    PixelFormat{"BayerBG10p", 0x010A0052, 10, 1, Mosaic::kBggr, kLsbPacked},
    PixelFormat{"BayerGB10p", 0x010A0054, 10, 1, Mosaic::kGbrg, kLsbPacked},
    PixelFormat{"BayerGR10p", 0x010A0056, 10, 1, Mosaic::kGrbg, kLsbPacked},
    PixelFormat{"BayerRG10p", 0x010A0058, 10, 1, Mosaic::kRggb, kLsbPacked},
    PixelFormat{"BayerBG12p", 0x010C0053, 12, 1, Mosaic::kBggr, kLsbPacked},
    PixelFormat{"BayerGB12p", 0x010C0055, 12, 1, Mosaic::kGbrg, kLsbPacked},
    PixelFormat{"BayerGR12p", 0x010C0057, 12, 1, Mosaic::kGrbg, kLsbPacked},
    PixelFormat{"BayerRG12p", 0x010C0059, 12, 1, Mosaic::kRggb, kLsbPacked},
    PixelFormat{"BayerGR10Packed", 0x010C0026, 10, 1, Mosaic::kGrbg, kGvspPacked},
    PixelFormat{"BayerRG10Packed", 0x010C0027, 10, 1, Mosaic::kRggb, kGvspPacked},
    PixelFormat{"BayerGB10Packed", 0x010C0028, 10, 1, Mosaic::kGbrg, kGvspPacked},
    PixelFormat{"BayerBG10Packed", 0x010C0029, 10, 1, Mosaic::kBggr, kGvspPacked},
    PixelFormat{"BayerGR12Packed", 0x010C002A, 12, 1, Mosaic::kGrbg, kGvspPacked},
    PixelFormat{"BayerRG12Packed", 0x010C002B, 12, 1, Mosaic::kRggb, kGvspPacked},
    PixelFormat{"BayerGB12Packed", 0x010C002C, 12, 1, Mosaic::kGbrg, kGvspPacked},
    PixelFormat{"BayerBG12Packed", 0x010C002D, 12, 1, Mosaic::kBggr, kGvspPacked},
    PixelFormat{"RGB8", 0x02180014, 8, 3, Mosaic::kNone, kWholeBytes, true},
    PixelFormat{"BGR8", 0x02180015, 8, 3},
};

// Full scale of `bits` becomes 65535: the value moves up, its high bits fill the low ones.
std::uint16_t SpreadTo16(std::uint32_t value, int bits) {
  value &= (1u << bits) - 1;
  return static_cast<std::uint16_t>((value << (16 - bits)) | (value >> (2 * bits - 16)));
}

void UnpackLsb(const std::uint8_t* bytes, std::size_t count, int bits, std::uint16_t* out) {
  std::uint32_t window = 0;
  int held = 0;
  for (std::size_t i = 0; i < count; ++i) {
    while (held < bits) {
      window |= static_cast<std::uint32_t>(*bytes++) << held;
      held += 8;
    }
    out[i] = SpreadTo16(window, bits);
    window >>= bits;
    held -= bits;
  }
}

void UnpackGvsp(const std::uint8_t* bytes, std::size_t count, int bits, std::uint16_t* out) {
  const int low_bits = bits - 8;
  const std::uint32_t low_mask = (1u << low_bits) - 1;
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint8_t* triple = bytes + 3 * (i / 2);
    const std::uint32_t high = i % 2 == 0 ? triple[0] : triple[2];
    const std::uint32_t low = (i % 2 == 0 ? triple[1] : triple[1] >> 4) & low_mask;
    out[i] = SpreadTo16(high << low_bits | low, bits);
  }
}

void SpreadWords(const std::uint8_t* bytes, std::size_t count, int bits, std::uint16_t* out) {
  for (std::size_t i = 0; i < count; ++i)
    out[i] = SpreadTo16(static_cast<std::uint32_t>(bytes[2 * i] | bytes[2 * i + 1] << 8), bits);
}

int Preference(const PixelFormat& format) {
  const int color = format.mosaic != Mosaic::kNone ? 200 : format.channels == 3 ? 100 : 0;
  const int depth = format.bits == 8 ? 50 : format.bits;
  return color + depth + (format.packing == kWholeBytes ? 1 : 0);
}

}  // namespace

std::optional<PixelFormat> PixelFormatByCode(std::uint32_t code) {
  for (const PixelFormat& format : kFormats)
    if (format.code == code) return format;
  return std::nullopt;
}

std::optional<PixelFormat> PixelFormatByName(std::string_view name) {
  // Names from before the naming convention that cameras still carry.
  if (name == "RGB8Packed") name = "RGB8";
  if (name == "BGR8Packed") name = "BGR8";
  for (const PixelFormat& format : kFormats)
    if (format.name == name) return format;
  return std::nullopt;
}

std::string SupportedPixelFormats() {
  std::string list;
  for (const PixelFormat& format : kFormats) list += (list.empty() ? "" : ", ") + std::string(format.name);
  return list;
}

std::size_t ImageBytes(const PixelFormat& format, int width, int height) {
  const std::size_t values = static_cast<std::size_t>(width) * static_cast<std::size_t>(height) *
                             static_cast<std::size_t>(format.channels);
  switch (format.packing) {
    case kLsbPacked:
      return (values * static_cast<std::size_t>(format.bits) + 7) / 8;
    case kGvspPacked:
      return (values * 3 + 1) / 2;
    default:
      return values * (format.bits > 8 ? 2 : 1);
  }
}

Image ImageFromBytes(const PixelFormat& format, int width, int height, const void* data, std::size_t size) {
  const std::size_t needed = ImageBytes(format, width, height);
  if (size < needed)
    throw Error(
        "a {} image of {}x{} has {} bytes, but only {} came; check the camera's format and packet size",
        format.name, width, height, needed, size);
  Image image{.pixels = {}, .transfer = Transfer::kLinear, .mosaic = format.mosaic};
  image.pixels.create(height, width, CV_MAKETYPE(format.bits > 8 ? CV_16U : CV_8U, format.channels));
  const auto* bytes = static_cast<const std::uint8_t*>(data);
  const std::size_t values = image.pixels.total() * static_cast<std::size_t>(format.channels);
  if (format.bits == 8) {
    std::memcpy(image.pixels.data, bytes, values);
    if (format.red_first) cv::cvtColor(image.pixels, image.pixels, cv::COLOR_RGB2BGR);
    return image;
  }
  auto* out = image.pixels.ptr<std::uint16_t>();
  if (format.packing == kLsbPacked)
    UnpackLsb(bytes, values, format.bits, out);
  else if (format.packing == kGvspPacked)
    UnpackGvsp(bytes, values, format.bits, out);
  else
    SpreadWords(bytes, values, format.bits, out);
  return image;
}

std::optional<PixelFormat> PreferredPixelFormat(const std::vector<std::string>& offered) {
  std::optional<PixelFormat> best;
  for (const std::string& name : offered)
    if (const auto format = PixelFormatByName(name);
        format && (!best || Preference(*format) > Preference(*best)))
      best = format;
  return best;
}

}  // namespace ulf
