#include "core/image/files/tiff_file.h"

#include <tiff.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "core/base/error.h"

namespace ulf {
namespace {

static_assert(std::endian::native == std::endian::little, "pixels are written as they are in memory");

// The pixels begin at a block boundary of any disk.
constexpr std::uint32_t kPixelsAt = 4096;
constexpr std::uint32_t kThreeShortsAt = 512, kFormatsAt = 520, kOneAt = 528;
using Header = std::array<char, kPixelsAt>;

class HeaderWriter {
 public:
  void Put(std::size_t at, const auto& value) { std::memcpy(header_.data() + at, &value, sizeof value); }
  void Entry(std::uint16_t tag, std::uint16_t type, std::uint32_t count, std::uint32_t value) {
    const std::size_t at = kFirstEntry + 12 * entries_++;
    Put(at, tag);
    Put(at + 2, type);
    Put(at + 4, count);
    Put(at + 8, value);
    Put(kDirectory, static_cast<std::uint16_t>(entries_));
  }
  Header Done() {
    std::memcpy(header_.data(), "II*\0", 4);
    Put(4, std::uint32_t{kDirectory});
    return header_;
  }

 private:
  static constexpr std::size_t kDirectory = 8, kFirstEntry = kDirectory + 2;
  Header header_{};
  std::size_t entries_ = 0;
};

Header HeaderOf(const cv::Mat& pixels, std::uint32_t pixel_bytes) {
  const auto width = static_cast<std::uint32_t>(pixels.cols),
             height = static_cast<std::uint32_t>(pixels.rows),
             channels = static_cast<std::uint32_t>(pixels.channels());
  const auto bits = static_cast<std::uint16_t>(8 * pixels.elemSize1());
  const std::uint16_t format = pixels.depth() == CV_32F ? SAMPLEFORMAT_IEEEFP : SAMPLEFORMAT_UINT;
  HeaderWriter header;
  for (std::uint32_t i = 0; i < 3; ++i) {
    header.Put(kThreeShortsAt + 2 * i, bits);
    header.Put(kFormatsAt + 2 * i, format);
  }
  header.Put(kOneAt, std::array<std::uint32_t, 2>{1, 1});
  const bool color = channels == 3;
  header.Entry(TIFFTAG_IMAGEWIDTH, TIFF_LONG, 1, width);
  header.Entry(TIFFTAG_IMAGELENGTH, TIFF_LONG, 1, height);
  header.Entry(TIFFTAG_BITSPERSAMPLE, TIFF_SHORT, channels, color ? kThreeShortsAt : bits);
  header.Entry(TIFFTAG_COMPRESSION, TIFF_SHORT, 1, COMPRESSION_NONE);
  header.Entry(TIFFTAG_PHOTOMETRIC, TIFF_SHORT, 1, color ? PHOTOMETRIC_RGB : PHOTOMETRIC_MINISBLACK);
  header.Entry(TIFFTAG_STRIPOFFSETS, TIFF_LONG, 1, kPixelsAt);
  header.Entry(TIFFTAG_SAMPLESPERPIXEL, TIFF_SHORT, 1, channels);
  header.Entry(TIFFTAG_ROWSPERSTRIP, TIFF_LONG, 1, height);
  header.Entry(TIFFTAG_STRIPBYTECOUNTS, TIFF_LONG, 1, pixel_bytes);
  header.Entry(TIFFTAG_XRESOLUTION, TIFF_RATIONAL, 1, kOneAt);
  header.Entry(TIFFTAG_YRESOLUTION, TIFF_RATIONAL, 1, kOneAt);
  header.Entry(TIFFTAG_RESOLUTIONUNIT, TIFF_SHORT, 1, RESUNIT_NONE);
  header.Entry(TIFFTAG_SAMPLEFORMAT, TIFF_SHORT, channels, color ? kFormatsAt : format);
  return header.Done();
}

// `out` may begin and end inside a pixel; OpenCV converts whole pixels, many at a time.
template <typename T>
void CopyAsRgb(const char* bgr, std::size_t first, std::span<char> out) {
  const auto* in = reinterpret_cast<const T*>(bgr) + first / sizeof(T) / 3 * 3;
  auto* to = reinterpret_cast<T*>(out.data());
  const std::size_t skipped = first / sizeof(T) % 3, end = skipped + out.size() / sizeof(T);
  std::size_t i = skipped;  // relative to the pixel in which `out` begins
  for (; i < end && i % 3 != 0; ++i) to[i - skipped] = in[i / 3 * 3 + 2 - i % 3];
  if (const int whole = static_cast<int>((end - i) / 3); whole > 0) {
    const cv::Mat from(1, whole, CV_MAKETYPE(cv::DataType<T>::depth, 3), const_cast<T*>(in + i));
    cv::Mat rgb(1, whole, from.type(), to + i - skipped);
    cv::cvtColor(from, rgb, cv::COLOR_BGR2RGB);
    i += 3 * static_cast<std::size_t>(whole);
  }
  for (; i < end; ++i) to[i - skipped] = in[i / 3 * 3 + 2 - i % 3];
}

// Copies bytes from `first` on of a row in the file's format.
void CopyRow(const cv::Mat& pixels, int row, std::size_t first, std::span<char> out) {
  const char* bytes = pixels.ptr<char>(row);
  if (pixels.channels() == 1)
    std::memcpy(out.data(), bytes + first, out.size());
  else if (pixels.elemSize1() == 1)
    CopyAsRgb<std::uint8_t>(bytes, first, out);
  else if (pixels.elemSize1() == 2)
    CopyAsRgb<std::uint16_t>(bytes, first, out);
  else
    CopyAsRgb<float>(bytes, first, out);
}

}  // namespace

FileContent TiffContent(const cv::Mat& pixels) {
  const int depth = pixels.depth();
  if (pixels.empty() || (depth != CV_8U && depth != CV_16U && depth != CV_32F) ||
      (pixels.channels() != 1 && pixels.channels() != 3))
    throw Error(
        "a picture of {} channels of OpenCV's depth {} cannot be kept as TIFF; convert it to 1 or 3 channels "
        "of 8 bits, 16 bits or float",
        pixels.channels(), depth);
  const std::size_t row_bytes = static_cast<std::size_t>(pixels.cols) * pixels.elemSize(),
                    pixel_bytes = row_bytes * static_cast<std::size_t>(pixels.rows);
  if (pixel_bytes > std::numeric_limits<std::uint32_t>::max() - kPixelsAt)
    throw Error("a picture of {}x{} is too large for TIFF", pixels.cols, pixels.rows);
  return {kPixelsAt + pixel_bytes,
          [pixels, row_bytes, header = HeaderOf(pixels, static_cast<std::uint32_t>(pixel_bytes))](
              std::uint64_t offset, std::span<char> out) {
            while (!out.empty()) {
              std::size_t size = 0;
              if (offset < kPixelsAt) {
                size = std::min<std::size_t>(out.size(), kPixelsAt - offset);
                std::memcpy(out.data(), header.data() + offset, size);
              } else {
                const std::uint64_t at = offset - kPixelsAt, row = at / row_bytes, first = at % row_bytes;
                size = std::min<std::size_t>(out.size(), row_bytes - first);
                CopyRow(pixels, static_cast<int>(row), first, out.first(size));
              }
              offset += size;
              out = out.subspan(size);
            }
          }};
}

cv::Mat PixelsOfTiff(std::string_view bytes, const cv::Size& size, int type) {
  cv::Mat pixels(size, type);
  const FileContent same = TiffContent(pixels);
  std::string header(kPixelsAt, 0);
  same.copy(0, header);
  if (pixels.channels() != 1 || bytes.size() != same.size || !bytes.starts_with(header)) return {};
  std::memcpy(pixels.data, bytes.data() + kPixelsAt, bytes.size() - kPixelsAt);
  return pixels;
}

}  // namespace ulf
