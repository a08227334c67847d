// What a camera sends, as an ulf::Image. Formats are named and numbered by the GenICam Pixel Format Naming
// Convention (PFNC), those that only webcams have by the names they have there. Unpacked, no demosaicing
// here: a mosaic stays what the sensor saw, and says its pattern.
//
// Values of 10 to 14 bits are spread over 16 so that full scale is 65535 exactly (unpack.h). Machine-vision
// cameras are linear unless their gamma is switched on; luma with chroma and JPEG are display-encoded.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/image/image.h"

namespace ulf {

enum class PixelPacking {
  kWholeBytes,  // 8 bits, or 16 with the value in the low bits, little-endian
  kLsbPacked,   // PFNC's "p": a stream of bits, lowest first
  kGvspPacked,  // GigE Vision's "Packed": two pixels in three bytes, the low bits of both in the middle one
  kYuyv,        // two pixels in four bytes: Y0 U Y1 V
  kUyvy,        // U Y0 V Y1
  kNv12,        // a plane of Y, then one of U V pairs, each for two by two pixels
  kJpeg,        // a whole JPEG of any length
};

// What luma and chroma mean: the matrix, and whether 8 bits are used in full or Y from 16 to 235, U and V
// from 16 to 240.
enum class YuvMatrix { kBt601, kBt709, kBt2020 };
struct YuvEncoding {
  YuvMatrix matrix = YuvMatrix::kBt601;
  bool full_range = false;
  bool operator==(const YuvEncoding&) const = default;
};

struct PixelFormat {
  std::string_view name;   // "BayerRG12p"
  std::uint32_t code = 0;  // PFNC's 32-bit number; 0: it has none
  int bits = 8;            // per value
  int channels = 1;
  Mosaic mosaic = Mosaic::kNone;
  PixelPacking packing = PixelPacking::kWholeBytes;
  bool red_first = false;  // R, G, B in memory
  YuvEncoding yuv = {};
};

// What the format alone does not say.
struct BytesLayout {
  std::size_t row_bytes = 0;  // with padding; 0: none
  std::optional<YuvEncoding> yuv = {};
};

std::optional<PixelFormat> PixelFormatByCode(std::uint32_t code);
std::optional<PixelFormat> PixelFormatByName(std::string_view name);
// "Mono8, Mono10, ...": for error messages.
std::string SupportedPixelFormats();

// The bytes of one image without padding at the end of rows; of a JPEG, the least.
std::size_t ImageBytes(const PixelFormat& format, int width, int height);

// Copies and unpacks, or decodes. Throws Error when `size` is smaller than the image, when luma and chroma
// cannot have that size, or when a JPEG cannot be decoded or has another size.
Image ImageFromBytes(const PixelFormat& format, int width, int height, const void* data, std::size_t size,
                     const BytesLayout& layout = {});

// The best of what a camera offers for a light field: colour before grey, the raw mosaic before what the
// camera interpolated, whole colours before shared ones, 8 bits before more (a third of the bandwidth; the
// rest is asked for by name). None: nothing is supported.
std::optional<PixelFormat> PreferredPixelFormat(const std::vector<std::string>& offered);

}  // namespace ulf
