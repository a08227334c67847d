// Converts the bytes that a camera sends to an ulf::Image. Formats have the names and numbers of GenICam's
// Pixel Format Naming Convention (PFNC); formats that only webcams have, have their usual names. A mosaic
// stays a mosaic, with its pattern.
//
// Values of 10 to 14 bits are spread over 16 so that full scale is exactly 65535. Grey values, mosaics and
// RGB are taken as linear; luma with chroma and JPEG are display-encoded.
#pragma once

#include <cstddef>
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

// Says how luma and chroma encode colour: by the matrix, and by the range, which is all 256 levels, or Y
// from 16 to 235 and U, V from 16 to 240.
enum class YuvMatrix { kBt601, kBt709, kBt2020 };
struct YuvEncoding {
  YuvMatrix matrix = YuvMatrix::kBt601;
  bool full_range = false;
  bool operator==(const YuvEncoding&) const = default;
};

struct PixelFormat {
  std::string_view name;   // "BayerRG12p"
  std::uint32_t code = 0;  // PFNC's 32-bit number; 0: it has none
  int bits = 8;            // per value: 8, 10, 12, 14 or 16
  int channels = 1;
  Mosaic mosaic = Mosaic::kNone;
  PixelPacking packing = PixelPacking::kWholeBytes;
  bool red_first = false;  // R, G, B in memory
  YuvEncoding yuv = {};
};

// Describes what the format alone does not tell.
struct BytesLayout {
  std::size_t row_bytes = 0;            // from row to row, with padding; 0: there is none
  std::optional<YuvEncoding> yuv = {};  // in place of PixelFormat::yuv
};

// These return none for a format that is not supported.
std::optional<PixelFormat> PixelFormatByCode(std::uint32_t code);
std::optional<PixelFormat> PixelFormatByName(std::string_view name);
// Returns the names of all formats, "Mono8, Mono10, ...", for error messages.
std::string SupportedPixelFormats();

// Returns the bytes of one image without padding at the end of rows; for JPEG the least possible number.
std::size_t ImageBytes(const PixelFormat& format, int width, int height);

// Copies and unpacks, or decodes, `size` bytes. Throws Error if the image has no pixels, if bytes or rows are
// too few, if luma and chroma cannot have that size, or if a JPEG is damaged or has another size.
Image ImageFromBytes(const PixelFormat& format, int width, int height, const void* data, std::size_t size,
                     const BytesLayout& layout = {});

// Returns the best of the formats that a camera offers, for a light field: colour before grey, the raw
// mosaic before colours that the camera interpolated, full colour before subsampled chroma, 8 bits before
// more (less bandwidth; users name deeper formats). Returns none if no format is supported.
std::optional<PixelFormat> PreferredPixelFormat(const std::vector<std::string>& offered);

// The next three functions unpack `count` values of n = `bits` bits from `bytes` and spread them over 16 bits
// by repeating the high bits: nearly v * 65535 / (2^n - 1), exactly at full scale, monotone and reversible.

// Unpacks PFNC's "p": a stream of bits, lowest first. `bits` is 10, 12 or 14.
void UnpackLsb(const std::uint8_t* bytes, std::size_t count, int bits, std::uint16_t* out);

// Unpacks GigE Vision's "Packed": two values in three bytes, low bits in the middle. `bits` is 10 or 12.
void UnpackGvsp(const std::uint8_t* bytes, std::size_t count, int bits, std::uint16_t* out);

// Unpacks 16-bit little-endian words of `bits` low bits, 10 to 16; the bits above are ignored.
void UnpackWords(const std::uint8_t* bytes, std::size_t count, int bits, std::uint16_t* out);

}  // namespace ulf
