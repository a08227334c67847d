// What a machine-vision camera sends, as an ulf::Image. Formats are named and numbered by the GenICam Pixel
// Format Naming Convention (PFNC). Unpacked, no demosaicing here: a mosaic stays what the sensor saw, and
// says its pattern.
//
// Values of 10 to 14 bits are spread over 16 so that full scale is 65535 exactly (v·65535/(2^n−1), by
// repeating the high bits): monotone and reversible. Machine-vision cameras are linear unless their gamma is
// switched on.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "acquisition/image.h"

namespace ulf {

enum class PixelPacking {
  kWholeBytes,  // 8 bits, or 16 with the value in the low bits, little-endian
  kLsbPacked,   // PFNC's "p": a stream of bits, lowest first
  kGvspPacked,  // GigE Vision's "Packed": two pixels in three bytes, the low bits of both in the middle one
};

struct PixelFormat {
  std::string_view name;   // "BayerRG12p"
  std::uint32_t code = 0;  // PFNC's 32-bit number
  int bits = 8;            // per value
  int channels = 1;
  Mosaic mosaic = Mosaic::kNone;
  PixelPacking packing = PixelPacking::kWholeBytes;
  bool red_first = false;  // R, G, B in memory
};

std::optional<PixelFormat> PixelFormatByCode(std::uint32_t code);
std::optional<PixelFormat> PixelFormatByName(std::string_view name);
// "Mono8, Mono10, ...": for error messages.
std::string SupportedPixelFormats();

// The bytes of one image without padding at the end of rows.
std::size_t ImageBytes(const PixelFormat& format, int width, int height);

// Copies and unpacks. Throws Error when `size` is smaller than the image.
Image ImageFromBytes(const PixelFormat& format, int width, int height, const void* data, std::size_t size);

// The best of what a camera offers for a light field: colour before grey, the raw mosaic before what the
// camera interpolated, 8 bits before more (a third of the bandwidth; the rest is asked for by name). None:
// nothing is supported.
std::optional<PixelFormat> PreferredPixelFormat(const std::vector<std::string>& offered);

}  // namespace ulf
