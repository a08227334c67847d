#include "acquisition/v4l2/motion_jpeg.h"

#include "core/image/files/jpeg_codec.h"

#include <vector>

namespace ulf::acquisition {
namespace {

constexpr std::uint8_t kStart = 0xD8, kEndOfPicture = 0xD9, kScan = 0xDA, kHuffmanTables = 0xC4;

struct Segment {
  std::uint8_t marker = 0;
  std::size_t begin = 0, end = 0;  // with its marker
};

// The segments of the header, up to that of the first scan.
std::vector<Segment> Segments(std::span<const std::uint8_t> jpeg) {
  std::vector<Segment> segments;
  std::size_t at = 2;
  while (at + 4 <= jpeg.size() && jpeg[at] == 0xFF) {
    const std::size_t length = static_cast<std::size_t>(jpeg[at + 2] << 8 | jpeg[at + 3]);
    segments.push_back({jpeg[at + 1], at, at + 2 + length});
    if (jpeg[at + 1] == kScan) break;
    at += 2 + length;
  }
  return segments;
}

// The standard's tables (ITU-T T.81, Annex K.3), taken from an encoder that does not optimise.
const std::string& StandardTables() {
  static const std::string tables = [] {
    const std::string encoded = JpegBytes(cv::Mat(16, 16, CV_8UC3, cv::Scalar(1, 2, 3)));
    const std::vector<std::uint8_t> jpeg(encoded.begin(), encoded.end());
    std::string found;
    for (const Segment& segment : Segments(jpeg))
      if (segment.marker == kHuffmanTables)
        found.append(jpeg.begin() + static_cast<std::ptrdiff_t>(segment.begin),
                     jpeg.begin() + static_cast<std::ptrdiff_t>(segment.end));
    return found;
  }();
  return tables;
}

}  // namespace

std::optional<std::string> StandaloneJpeg(std::span<const std::uint8_t> bytes) {
  if (bytes.size() < 4 || bytes[0] != 0xFF || bytes[1] != kStart) return std::nullopt;
  // Padding may follow the end marker, which cannot occur inside the scan.
  std::size_t end = bytes.size();
  while (end >= 4 && !(bytes[end - 2] == 0xFF && bytes[end - 1] == kEndOfPicture)) --end;
  if (end < 4) return std::nullopt;
  std::string jpeg(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(end));
  std::size_t scan = 0;
  for (const Segment& segment : Segments(bytes.first(end))) {
    if (segment.marker == kHuffmanTables) return jpeg;
    if (segment.marker == kScan) scan = segment.begin;
  }
  if (scan > 0) jpeg.insert(scan, StandardTables());
  return jpeg;
}

}  // namespace ulf::acquisition
