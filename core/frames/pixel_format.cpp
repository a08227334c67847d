#include "core/frames/pixel_format.h"

#include <fmt/format.h>

#include <array>
#include <bit>
#include <cstring>
#include <opencv2/imgproc.hpp>

#include "core/base/error.h"
#include "core/image/files/jpeg_codec.h"

namespace ulf {

namespace {

using enum PixelPacking;
using enum YuvMatrix;

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
    PixelFormat{"BayerGR14", 0x01100109, 14, 1, Mosaic::kGrbg},
    PixelFormat{"BayerRG14", 0x0110010A, 14, 1, Mosaic::kRggb},
    PixelFormat{"BayerGB14", 0x0110010B, 14, 1, Mosaic::kGbrg},
    PixelFormat{"BayerBG14", 0x0110010C, 14, 1, Mosaic::kBggr},
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
    // In PFNC, YUV and YCbCr without a number are BT.601 over all 256 levels, the numbered ones have 16 to
    // 235.
    PixelFormat{"YUV422_8", 0x02100032, 8, 3, Mosaic::kNone, kYuyv, false, {kBt601, true}},
    PixelFormat{"YUV422_8_UYVY", 0x0210001F, 8, 3, Mosaic::kNone, kUyvy, false, {kBt601, true}},
    PixelFormat{"YCbCr422_8", 0x0210003B, 8, 3, Mosaic::kNone, kYuyv, false, {kBt601, true}},
    PixelFormat{"YCbCr422_8_CbYCrY", 0x02100043, 8, 3, Mosaic::kNone, kUyvy, false, {kBt601, true}},
    PixelFormat{"YCbCr601_422_8", 0x0210003E, 8, 3, Mosaic::kNone, kYuyv},
    PixelFormat{"YCbCr601_422_8_CbYCrY", 0x02100044, 8, 3, Mosaic::kNone, kUyvy},
    PixelFormat{"YCbCr709_422_8", 0x02100041, 8, 3, Mosaic::kNone, kYuyv, false, {kBt709, false}},
    PixelFormat{"YCbCr709_422_8_CbYCrY", 0x02100045, 8, 3, Mosaic::kNone, kUyvy, false, {kBt709, false}},
    // Webcams use their own names; the driver says how the colours are coded.
    PixelFormat{"YUYV", 0, 8, 3, Mosaic::kNone, kYuyv},
    PixelFormat{"UYVY", 0, 8, 3, Mosaic::kNone, kUyvy},
    PixelFormat{"NV12", 0, 8, 3, Mosaic::kNone, kNv12},
    PixelFormat{"MJPEG", 0, 8, 3, Mosaic::kNone, kJpeg},
};

bool IsYuv(const PixelFormat& format) {
  return format.packing == kYuyv || format.packing == kUyvy || format.packing == kNv12;
}

std::size_t RowBytes(const PixelFormat& format, std::size_t width) {
  const std::size_t values = width * static_cast<std::size_t>(format.channels);
  switch (format.packing) {
    case kWholeBytes:
      return values * (format.bits > 8 ? 2 : 1);
    case kLsbPacked:
      return (values * static_cast<std::size_t>(format.bits) + 7) / 8;
    case kGvspPacked:
      return (values * 3 + 1) / 2;
    case kYuyv:
    case kUyvy:
      return 2 * width;
    case kNv12:
    case kJpeg:
      return width;
  }
  return 0;
}

// Returns B, G, R from Y, U, V as a 3x4 matrix on 8-bit values.
cv::Matx34f BgrFromYuv(const YuvEncoding& encoding) {
  double red = 0.299, blue = 0.114;
  if (encoding.matrix == kBt709) red = 0.2126, blue = 0.0722;
  if (encoding.matrix == kBt2020) red = 0.2627, blue = 0.0593;
  const double green = 1 - red - blue;
  const double scale_y = encoding.full_range ? 1 : 255.0 / 219, black = encoding.full_range ? 0 : 16;
  const double scale_c = encoding.full_range ? 1 : 255.0 / 224;
  const double r_v = scale_c * 2 * (1 - red), b_u = scale_c * 2 * (1 - blue);
  const double g_u = -b_u * blue / green, g_v = -r_v * red / green;
  const auto row = [&](double u, double v) {
    return cv::Vec4d(scale_y, u, v, -scale_y * black - 128 * (u + v));
  };
  const cv::Vec4d b = row(b_u, 0), g = row(g_u, g_v), r = row(0, r_v);
  cv::Matx34f matrix;
  for (int i = 0; i < 4; ++i) {
    matrix(0, i) = static_cast<float>(b[i]);
    matrix(1, i) = static_cast<float>(g[i]);
    matrix(2, i) = static_cast<float>(r[i]);
  }
  return matrix;
}

// Each pixel takes the chroma sample of its pair or block, as OpenCV's own conversions do.
cv::Mat BgrFromYuv(const PixelFormat& format, int width, int height, const std::uint8_t* bytes,
                   std::size_t stride, const YuvEncoding& encoding) {
  auto* data = const_cast<std::uint8_t*>(bytes);
  const bool is_nv12 = format.packing == kNv12;
  cv::Mat bgr;
  if (encoding == YuvEncoding{} && !is_nv12) {
    cv::cvtColor(cv::Mat(height, width, CV_8UC2, data, stride), bgr,
                 format.packing == kYuyv ? cv::COLOR_YUV2BGR_YUYV : cv::COLOR_YUV2BGR_UYVY);
    return bgr;
  }
  const cv::Size half(width / 2, is_nv12 ? height / 2 : height);
  cv::Mat luma, chroma;
  if (is_nv12) {
    luma = cv::Mat(height, width, CV_8U, data, stride);
    chroma = cv::Mat(half, CV_8UC2, data + stride * static_cast<std::size_t>(height), stride);
    if (encoding == YuvEncoding{}) {
      cv::cvtColorTwoPlane(luma, chroma, bgr, cv::COLOR_YUV2BGR_NV12);
      return bgr;
    }
  } else {
    const int first_luma = format.packing == kYuyv ? 0 : 1;
    cv::extractChannel(cv::Mat(height, width, CV_8UC2, data, stride), luma, first_luma);
    const cv::Mat pairs(height, width / 2, CV_8UC4, data, stride);
    chroma.create(half, CV_8UC2);
    const std::array<int, 4> from_to{1 - first_luma, 0, 3 - first_luma, 1};
    cv::mixChannels(&pairs, 1, &chroma, 1, from_to.data(), 2);
  }
  cv::Mat wide_chroma, yuv;
  cv::resize(chroma, wide_chroma, {width, height}, 0, 0, cv::INTER_NEAREST);
  cv::merge(std::array{luma, wide_chroma}, yuv);
  cv::transform(yuv, bgr, BgrFromYuv(encoding));
  return bgr;
}

cv::Mat BgrFromJpeg(int width, int height, const std::uint8_t* bytes, std::size_t size) {
  const DecodedJpeg decoded = DecodeWebcamJpeg({bytes, size}, {width, height});
  if (!decoded.damage.empty())
    throw Error("{} bytes of JPEG are damaged ({}); the cable or the hub may lose data", size,
                decoded.damage);
  if (decoded.bgr.empty())
    throw Error("the JPEG is {}x{}, but {}x{} was configured; open the camera again", decoded.size.width,
                decoded.size.height, width, height);
  return decoded.bgr;
}

// Copies values of 8 bits and unpacks others. Rows may be padded.
void FillPixels(const PixelFormat& format, const std::uint8_t* bytes, std::size_t stride, cv::Mat& pixels) {
  const bool rows_follow = stride == 0 || (format.packing == kWholeBytes &&
                                           stride == RowBytes(format, static_cast<std::size_t>(pixels.cols)));
  const int strips = rows_follow ? 1 : pixels.rows;
  const std::size_t values =
      pixels.total() * static_cast<std::size_t>(format.channels) / static_cast<std::size_t>(strips);
  for (int strip = 0; strip < strips; ++strip) {
    const std::uint8_t* from = bytes + stride * static_cast<std::size_t>(strip);
    if (format.bits == 8) {
      std::memcpy(pixels.ptr(strip), from, values);
      continue;
    }
    auto* out = pixels.ptr<std::uint16_t>(strip);
    if (format.packing == kLsbPacked)
      UnpackLsb(from, values, format.bits, out);
    else if (format.packing == kGvspPacked)
      UnpackGvsp(from, values, format.bits, out);
    else
      UnpackWords(from, values, format.bits, out);
  }
}

int Preference(const PixelFormat& format) {
  int color = 0;
  if (format.mosaic != Mosaic::kNone)
    color = 300;
  else if (format.packing == kJpeg)
    color = 80;
  else if (format.packing == kNv12)
    color = 100;
  else if (IsYuv(format))
    color = 150;
  else if (format.channels == 3)
    color = 200;
  const int depth = format.bits == 8 ? 50 : format.bits;
  return color + depth + (format.packing == kWholeBytes ? 1 : 0);
}

static_assert(std::endian::native == std::endian::little, "words of pixels are loaded as they lie in memory");

constexpr std::uint64_t FourTimes(std::uint64_t lane) { return lane * 0x0001'0001'0001'0001u; }

std::uint16_t SpreadTo16(std::uint32_t value, int bits) {
  value &= (1u << bits) - 1;
  return static_cast<std::uint16_t>((value << (16 - bits)) | (value >> (2 * bits - 16)));
}

// Does the same on four 16-bit lanes.
template <int kBits>
std::uint64_t SpreadLanes(std::uint64_t values) {
  constexpr std::uint64_t kLowBits = FourTimes((1u << (16 - kBits)) - 1);
  return (values << (16 - kBits)) | ((values >> (2 * kBits - 16)) & kLowBits);
}

// Loads four consecutive values of a stream of bits, one into each lane.
template <int kBits>
std::uint64_t LanesOfStream(std::uint64_t stream) {
  constexpr std::uint64_t kPair = (std::uint64_t{1} << (2 * kBits)) - 1;
  constexpr std::uint64_t kValue = (std::uint64_t{1} << kBits) - 1;
  constexpr std::uint64_t kEven = kValue | kValue << 32;
  const std::uint64_t pairs = (stream & kPair) | ((stream & (kPair << (2 * kBits))) << (32 - 2 * kBits));
  return (pairs & kEven) | ((pairs & (kEven << kBits)) << (16 - kBits));
}

// Loads two triples of bytes, each a high byte, the low bits of both, a high byte: one value in each lane.
template <int kBits>
std::uint64_t LanesOfTriples(std::uint64_t bytes) {
  constexpr int kLow = kBits - 8;
  constexpr std::uint64_t kLowBits = (1u << kLow) - 1;
  constexpr std::uint64_t kBoth = 0x0000'0001'0000'0001u;  // two 32-bit halves
  const std::uint64_t triples = (bytes & 0xFF'FFFF) | ((bytes & 0xFFFF'FF00'0000u) << 8);
  const std::uint64_t first = ((triples & (0xFF * kBoth)) << kLow) | ((triples >> 8) & (kLowBits * kBoth));
  const std::uint64_t second =
      (((triples >> 16) & (0xFF * kBoth)) << kLow) | ((triples >> 12) & (kLowBits * kBoth));
  return first | second << 16;
}

// Unpacks whole groups of four values in kGroupBytes bytes, as long as eight can be read. Returns the values
// done.
template <int kGroupBytes, typename Unpack>
std::size_t UnpackGroups(const std::uint8_t* bytes, std::size_t size, std::uint16_t* out, Unpack unpack) {
  if (size < 8) return 0;
  const std::size_t groups = (size - 8) / kGroupBytes + 1;
  for (std::size_t i = 0; i < groups; ++i) {
    std::uint64_t word;
    std::memcpy(&word, bytes + i * kGroupBytes, sizeof word);
    const std::uint64_t lanes = unpack(word);
    std::memcpy(out + 4 * i, &lanes, sizeof lanes);
  }
  return 4 * groups;
}

}  // namespace

std::optional<PixelFormat> PixelFormatByCode(std::uint32_t code) {
  if (code == 0) return std::nullopt;  // webcams' formats have no number
  for (const PixelFormat& format : kFormats)
    if (format.code == code) return format;
  return std::nullopt;
}

std::optional<PixelFormat> PixelFormatByName(std::string_view name) {
  // Older names that some cameras still use.
  if (name == "RGB8Packed") name = "RGB8";
  if (name == "BGR8Packed") name = "BGR8";
  for (const PixelFormat& format : kFormats)
    if (format.name == name) return format;
  return std::nullopt;
}

std::string SupportedPixelFormats() {
  std::vector<std::string_view> names;
  for (const PixelFormat& format : kFormats) names.push_back(format.name);
  return fmt::format("{}", fmt::join(names, ", "));
}

std::size_t ImageBytes(const PixelFormat& format, int width, int height) {
  const auto columns = static_cast<std::size_t>(width), rows = static_cast<std::size_t>(height);
  switch (format.packing) {
    case kLsbPacked:
    case kGvspPacked:  // rows are contiguous
      return RowBytes(format, columns * rows);
    case kNv12:
      return RowBytes(format, columns) * rows * 3 / 2;
    case kJpeg:
      return 4;  // its two markers; the length depends on the picture
    default:
      return RowBytes(format, columns) * rows;
  }
}

Image ImageFromBytes(const PixelFormat& format, int width, int height, const void* data, std::size_t size,
                     const BytesLayout& layout) {
  if (width < 1 || height < 1)
    throw Error("an image of {}x{} has no pixels; check the camera's region", width, height);
  if (IsYuv(format) && (width % 2 != 0 || (format.packing == kNv12 && height % 2 != 0)))
    throw Error("a {} image cannot be {}x{}: two pixels share a colour; choose another size", format.name,
                width, height);
  std::size_t needed = ImageBytes(format, width, height);
  const std::size_t row = RowBytes(format, static_cast<std::size_t>(width));
  if (layout.row_bytes > 0 && format.packing != kJpeg) {
    const auto rows = static_cast<std::size_t>(format.packing == kNv12 ? height * 3 / 2 : height);
    if (layout.row_bytes < row)
      throw Error("a row of {} {} pixels has {} bytes, not {}; check the camera's format", width, format.name,
                  row, layout.row_bytes);
    needed = layout.row_bytes * (rows - 1) + row;
  }
  if (size < needed)
    throw Error(
        "a {} image of {}x{} has {} bytes, but only {} came; check the camera's format and packet size",
        format.name, width, height, needed, size);
  const auto* bytes = static_cast<const std::uint8_t*>(data);
  if (format.packing == kJpeg) return {.pixels = BgrFromJpeg(width, height, bytes, size)};
  if (IsYuv(format)) {
    const std::size_t stride = layout.row_bytes > 0 ? layout.row_bytes : row;
    return {.pixels = BgrFromYuv(format, width, height, bytes, stride, layout.yuv.value_or(format.yuv))};
  }
  Image image{.pixels = {}, .transfer = Transfer::kLinear, .mosaic = format.mosaic};
  if (format.red_first) {
    const cv::Mat rgb(height, width, CV_8UC3, const_cast<std::uint8_t*>(bytes), layout.row_bytes);
    cv::cvtColor(rgb, image.pixels, cv::COLOR_RGB2BGR);
    return image;
  }
  image.pixels.create(height, width, CV_MAKETYPE(format.bits > 8 ? CV_16U : CV_8U, format.channels));
  FillPixels(format, bytes, layout.row_bytes, image.pixels);
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

void UnpackLsb(const std::uint8_t* bytes, std::size_t count, int bits, std::uint16_t* out) {
  const std::size_t whole = count / 4 * static_cast<std::size_t>(bits) / 2;  // bytes of whole groups
  std::size_t done = 0;
  if (bits == 10)
    done = UnpackGroups<5>(bytes, whole, out,
                           [](std::uint64_t word) { return SpreadLanes<10>(LanesOfStream<10>(word)); });
  else if (bits == 12)
    done = UnpackGroups<6>(bytes, whole, out,
                           [](std::uint64_t word) { return SpreadLanes<12>(LanesOfStream<12>(word)); });
  else if (bits == 14)
    done = UnpackGroups<7>(bytes, whole, out,
                           [](std::uint64_t word) { return SpreadLanes<14>(LanesOfStream<14>(word)); });
  bytes += done / 4 * static_cast<std::size_t>(bits) / 2;
  std::uint32_t window = 0;
  int held = 0;
  for (std::size_t i = done; i < count; ++i) {
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
  const std::size_t whole = count / 4 * 6;
  const std::size_t done =
      bits == 10
          ? UnpackGroups<6>(bytes, whole, out,
                            [](std::uint64_t word) { return SpreadLanes<10>(LanesOfTriples<10>(word)); })
          : UnpackGroups<6>(bytes, whole, out,
                            [](std::uint64_t word) { return SpreadLanes<12>(LanesOfTriples<12>(word)); });
  const int low_bits = bits - 8;
  const std::uint32_t low_mask = (1u << low_bits) - 1;
  for (std::size_t i = done; i < count; ++i) {
    const std::uint8_t* triple = bytes + 3 * (i / 2);
    const std::uint32_t high = i % 2 == 0 ? triple[0] : triple[2];
    const std::uint32_t low = (i % 2 == 0 ? triple[1] : triple[1] >> 4) & low_mask;
    out[i] = SpreadTo16(high << low_bits | low, bits);
  }
}

void UnpackWords(const std::uint8_t* bytes, std::size_t count, int bits, std::uint16_t* out) {
  std::memcpy(out, bytes, 2 * count);
  if (bits == 16) return;
  for (std::size_t i = 0; i < count; ++i) out[i] = SpreadTo16(out[i], bits);
}

}  // namespace ulf
