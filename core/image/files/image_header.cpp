#include "core/image/files/image_header.h"

#include <fmt/core.h>
#include <tiff.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <fstream>
#include <istream>
#include <sstream>
#include <string_view>
#include <vector>

#include "core/base/binary_file.h"
#include "core/base/error.h"
#include "core/image/files/picture_codecs.h"
#include "core/image/files/picture_kind.h"

namespace ulf {

namespace {

std::int64_t Side(std::string_view bytes) { return static_cast<std::int64_t>(BigEndian(bytes)); }

// Looks for a chunk tRNS, which comes before the pixels. A chunk has length, name, content, checksum.
bool HasTransparentColors(std::istream& file) {
  for (std::uint64_t at = 8;;) {
    const std::string chunk = BytesAt(file, at, 8),
                      name = chunk.substr(std::min<std::size_t>(4, chunk.size()));
    if (name.size() < 4 || name == "IDAT") return false;
    if (name == "tRNS") return true;
    at += 12 + BigEndian(chunk.substr(0, 4));
  }
}

// ISO 15948 has the signature, then IHDR with width, height, depth and colour type.
std::optional<ImageHeader> ReadPngHeader(std::istream& file) {
  const std::string head = BytesAt(file, 0, 26);
  if (head.size() < 26) return std::nullopt;
  // The colour types are grey, -, RGB, palette (decodes to three channels), grey and alpha, -, RGB and alpha.
  constexpr std::array kChannels = {1, 0, 3, 3, 2, 0, 4};
  const int color_type = static_cast<std::uint8_t>(head[25]), bits = static_cast<std::uint8_t>(head[24]);
  if (color_type >= static_cast<int>(kChannels.size()) || bits == 0 || bits > 16) return std::nullopt;
  const int channels = kChannels[static_cast<std::size_t>(color_type)];
  const bool alpha = channels == 2 || channels == 4 || HasTransparentColors(file);
  return ImageHeader{
      "PNG", Side(head.substr(16, 4)), Side(head.substr(20, 4)), channels, std::max(bits, 8), alpha, false};
}

// ITU T.81 has segments up to the start of frame, which has precision, height, width and components.
std::optional<ImageHeader> ReadJpegHeader(std::istream& file) {
  for (std::uint64_t at = 2;;) {
    const std::string segment = BytesAt(file, at, 4);
    if (segment.size() < 4) return std::nullopt;
    const int marker = static_cast<std::uint8_t>(segment[1]);
    if (segment[0] != '\xFF' || marker == 0xFF) {  // fill bytes before a marker
      ++at;
      continue;
    }
    constexpr int kStartOfScan = 0xDA;
    if (marker == kStartOfScan) return std::nullopt;
    const bool is_start_of_frame =
        marker >= 0xC0 && marker <= 0xCF && marker != 0xC4 && marker != 0xC8 && marker != 0xCC;
    if (is_start_of_frame) {
      const std::string frame = BytesAt(file, at + 4, 6);
      if (frame.size() < 6) return std::nullopt;
      const auto byte = [&](std::size_t i) { return static_cast<std::uint8_t>(frame[i]); };
      return ImageHeader{"JPEG", Side(frame.substr(3, 2)), Side(frame.substr(1, 2)), byte(5), byte(0), false,
                         false};
    }
    at += 2 + BigEndian(segment.substr(2));
  }
}

// TIFF 6.0 and BigTIFF have directories of entries with a tag, a type, a count, and a value or its place.
class Tiff {
 public:
  Tiff(std::istream& file, std::string_view begin)
      : file_(file), is_little_(begin[0] == 'I'), is_big_(begin[2] == '+' || begin[3] == '+') {}

  // Reads the first directory that is no thumbnail.
  std::optional<ImageHeader> Read() {
    const int wide = is_big_ ? 8 : 4;
    auto directory = NumberAt(is_big_ ? 8 : 4, wide);
    constexpr int kMostDirectories = 64;
    std::optional<ImageHeader> first;
    for (int i = 0; i < kMostDirectories && directory && *directory > 0; ++i) {
      bool is_picture = true;
      const auto header = ReadDirectory(*directory, wide, is_picture);
      if (!header) break;
      if (is_picture) return header;
      if (!first) first = header;
      directory = next_;
    }
    for (const std::int64_t inside : std::vector(inside_)) {
      bool is_picture = true;
      const auto header = ReadDirectory(inside, wide, is_picture);
      if (header && is_picture) return header;
    }
    return first;
  }

 private:
  std::optional<ImageHeader> ReadDirectory(std::int64_t directory, int wide, bool& is_picture) {
    const auto entries = NumberAt(directory, is_big_ ? 8 : 2);
    if (!entries) return std::nullopt;
    constexpr std::int64_t kMostEntries = 4096;
    ImageHeader header{"TIFF", 0, 0, 1, 1, false, false};
    const std::int64_t first = directory + (is_big_ ? 8 : 2), step = is_big_ ? 20 : 12;
    bool is_log = false;
    const std::int64_t count_read = std::min(*entries, kMostEntries);
    for (std::int64_t i = 0; i < count_read; ++i) {
      const std::int64_t at = first + i * step;
      const auto tag = NumberAt(at, 2), type = NumberAt(at + 2, 2), count = NumberAt(at + 4, wide);
      if (!tag || !type || !count) return std::nullopt;
      const int size = BytesOfNumber(*type);
      const std::int64_t value = at + 4 + wide;
      const bool is_inside = *count <= wide / size;
      const std::int64_t place = is_inside ? value : NumberAt(value, wide).value_or(-1);
      const std::int64_t number = NumberAt(place, size).value_or(0);
      constexpr std::int64_t kMostInside = 16;
      for (std::int64_t k = 0; *tag == TIFFTAG_SUBIFD && k < std::min(*count, kMostInside); ++k)
        if (const auto inside = NumberAt(place + k * size, size)) inside_.push_back(*inside);
      if (*tag == TIFFTAG_PHOTOMETRIC) is_log = number == PHOTOMETRIC_LOGL || number == PHOTOMETRIC_LOGLUV;
      if (*tag == TIFFTAG_SUBFILETYPE) is_picture = (number & (FILETYPE_REDUCEDIMAGE | FILETYPE_MASK)) == 0;
      if (*tag == TIFFTAG_IMAGEWIDTH) header.width = number;
      if (*tag == TIFFTAG_IMAGELENGTH) header.height = number;
      if (*tag == TIFFTAG_BITSPERSAMPLE)
        header.bits = static_cast<int>(std::clamp<std::int64_t>(number, 1, 64));
      if (*tag == TIFFTAG_SAMPLESPERPIXEL)
        header.channels = static_cast<int>(std::clamp<std::int64_t>(number, 1, 64));
      if (*tag == TIFFTAG_EXTRASAMPLES)
        header.alpha = number == EXTRASAMPLE_ASSOCALPHA || number == EXTRASAMPLE_UNASSALPHA;
      if (*tag == TIFFTAG_SAMPLEFORMAT) header.is_float = number == SAMPLEFORMAT_IEEEFP;
    }
    header.is_float = header.is_float || is_log;
    next_ = NumberAt(first + *entries * step, wide);
    return header.width > 0 && header.height > 0 ? std::optional(header) : std::nullopt;
  }
  // Returns the size of a value of that type, which is any integer type for a width.
  static int BytesOfNumber(std::int64_t type) {
    if (type == TIFF_BYTE || type == TIFF_SBYTE) return 1;
    if (type == TIFF_SHORT || type == TIFF_SSHORT) return 2;
    return type == TIFF_LONG || type == TIFF_SLONG || type == TIFF_IFD ? 4 : 8;
  }
  std::optional<std::int64_t> NumberAt(std::int64_t place, int count) {
    const auto size = static_cast<std::size_t>(count);
    const std::string bytes =
        place < 0 ? std::string() : BytesAt(file_, static_cast<std::uint64_t>(place), size);
    if (bytes.size() < size) return std::nullopt;
    return static_cast<std::int64_t>(is_little_ ? LittleEndian(bytes) : BigEndian(bytes));
  }

  std::istream& file_;
  bool is_little_, is_big_;
  std::vector<std::int64_t> inside_;  // directories inside those that were read
  std::optional<std::int64_t> next_;  // the next directory in the chain
};

constexpr std::size_t kBmpBytes = 26;

// The length of the second header tells OS/2's from Windows'; a negative height counts from the top.
cv::Size2d OfBmp(std::string_view head) {
  const auto number = [&](std::size_t at, std::size_t bytes) {
    return static_cast<std::int32_t>(static_cast<std::uint32_t>(LittleEndian(head.substr(at, bytes))));
  };
  constexpr int kOs2HeaderBytes = 12;
  if (number(14, 4) == kOs2HeaderBytes) return cv::Size2d(number(18, 2), number(20, 2));
  return cv::Size2d(number(18, 4), std::abs(1.0 * number(22, 4)));
}

// Two decimal numbers follow the kind, with comments between them, which end as in OpenCV.
std::optional<cv::Size2d> OfNetpbm(std::istream& file) {
  file.seekg(2);
  const auto number = [&]() -> double {
    char c = ' ';
    while (file.get(c) && (std::isspace(static_cast<unsigned char>(c)) != 0 || c == '#'))
      if (c == '#')
        while (file.get(c) && c != '\n' && c != '\r') continue;
    double value = 0;
    bool has_digits = false;
    for (; file && std::isdigit(static_cast<unsigned char>(c)) != 0; file.get(c)) {
      value = 10 * value + (c - '0');
      has_digits = true;
    }
    const bool ends = c == '#' || std::isspace(static_cast<unsigned char>(c)) != 0;
    if (c == '#') file.unget();
    return file && has_digits && ends ? value : -1;
  };
  const double width = number(), height = number();
  if (!(width > 0 && height > 0)) return std::nullopt;
  return cv::Size2d(width, height);
}

// Lines of text and an empty one precede "-Y height +X width"; OpenCV cuts longer lines in two.
std::optional<cv::Size2d> OfRadiance(std::istream& file) {
  constexpr int kMostLines = 1000;
  constexpr std::size_t kMostOfLine = 126;
  file.seekg(0);
  std::string line;
  for (int i = 0; i < kMostLines && std::getline(file, line) && !line.empty(); ++i)
    if (line.size() > kMostOfLine) return std::nullopt;
  std::getline(file, line);
  std::istringstream sides(line);
  std::string y, x;
  int height = 0, width = 0;
  if (!(sides >> y >> height >> x >> width) || y != "-Y" || x != "+X") return std::nullopt;
  return cv::Size2d(width, height);
}

}  // namespace

std::string ImageHeader::Text() const {
  return fmt::format("{} {}x{}, {} {} of {} bits{}{}", kind, width, height, channels,
                     channels == 1 ? "channel" : "channels", bits, is_float ? " in floating point" : "",
                     alpha ? ", with alpha" : "");
}

std::optional<ImageHeader> ReadImageHeader(std::istream& file) {
  const std::string signature = BytesAt(file, 0, 8);
  if (signature.size() < 8) return std::nullopt;
  if (signature == "\x89PNG\r\n\x1A\n") return ReadPngHeader(file);
  if (signature.starts_with("\xFF\xD8")) return ReadJpegHeader(file);
  for (const std::string_view tiff : {std::string_view("II*\0", 4), std::string_view("MM\0*", 4),
                                      std::string_view("II+\0", 4), std::string_view("MM\0+", 4)})
    if (signature.starts_with(tiff)) return Tiff(file, signature).Read();
  return std::nullopt;
}

std::optional<ImageHeader> ReadImageHeader(const std::string& path) {
  if (IsRawFile(path)) return std::nullopt;  // many are TIFF, with a small picture first
  if (std::error_code unknown; !std::filesystem::is_regular_file(path, unknown)) return std::nullopt;
  std::ifstream file(path, std::ios::binary);
  if (!file) return std::nullopt;
  return ReadImageHeader(file);
}

void RequirePixelsOfFile(const std::string& path, std::uint64_t file_bytes, double pixels,
                         double bytes_of_pixel) {
  constexpr double kAlwaysBytes = 256e6;
  // Deflate compresses at most 1032 to 1, and halves become floats.
  constexpr double kMostOfFile = 2100;
  const double bytes = pixels * bytes_of_pixel;
  if (bytes > std::max(kAlwaysBytes, kMostOfFile * static_cast<double>(file_bytes)))
    throw Error(
        "{}: says that it holds {:.0f} million pixels, which do not fit into {} bytes; it is damaged: "
        "copy it again from its source",
        path, 1e-6 * pixels, file_bytes);
}

std::optional<cv::Size2d> ClaimedSize(std::istream& file) {
  const std::string head = BytesAt(file, 0, kBmpBytes);
  file.clear();
  if (head.size() > 1 && head[0] == 'P' &&
      std::string_view("123456Ff").find(head[1]) != std::string_view::npos)
    return OfNetpbm(file);
  if (head.starts_with("#?")) return OfRadiance(file);
  if (head.size() < kBmpBytes) return std::nullopt;
  if (head.starts_with("BM")) return OfBmp(head);
  if (head.starts_with("RIFF") && std::string_view(head).substr(8, 4) == "WEBP")
    return WebpSize(BytesAt(file, 0, 256));
  return std::nullopt;
}

}  // namespace ulf
