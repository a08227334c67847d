#include "core/image/files/claimed_size.h"

#include <cctype>
#include <cmath>
#include <cstdint>
#include <istream>
#include <sstream>
#include <string>
#include <string_view>

namespace ulf {
namespace {

constexpr std::size_t kHeadBytes = 32;

double LittleEndian(std::string_view head, std::size_t at, int bytes) {
  std::uint64_t value = 0;
  for (int i = bytes; i-- > 0;)
    value = value << 8 | static_cast<std::uint8_t>(head[at + static_cast<std::size_t>(i)]);
  return static_cast<double>(value);
}

double Signed32(std::string_view head, std::size_t at) {
  return static_cast<std::int32_t>(static_cast<std::uint32_t>(LittleEndian(head, at, 4)));
}

// The length of the second header tells OS/2's from Windows'; a negative height counts from the top.
cv::Size2d OfBmp(std::string_view head) {
  constexpr double kOs2HeaderBytes = 12;
  if (LittleEndian(head, 14, 4) == kOs2HeaderBytes)
    return {LittleEndian(head, 18, 2), LittleEndian(head, 20, 2)};
  return {Signed32(head, 18), std::abs(Signed32(head, 22))};
}

// RFC 9649: a lossy frame, a lossless one, or a header of its own.
std::optional<cv::Size2d> OfWebp(std::string_view head) {
  const std::string_view kind = head.substr(12, 4);
  constexpr std::uint32_t kFourteenBits = 0x3FFF;
  if (kind == "VP8 ") {
    const auto side = [&](std::size_t at) {
      return static_cast<double>(static_cast<std::uint32_t>(LittleEndian(head, at, 2)) & kFourteenBits);
    };
    return cv::Size2d(side(26), side(28));
  }
  if (kind == "VP8L") {
    const auto sides = static_cast<std::uint32_t>(LittleEndian(head, 21, 4));
    return cv::Size2d((sides & kFourteenBits) + 1, (sides >> 14 & kFourteenBits) + 1);
  }
  if (kind == "VP8X") return cv::Size2d(LittleEndian(head, 24, 3) + 1, LittleEndian(head, 27, 3) + 1);
  return std::nullopt;
}

// Two numbers of digits behind the kind, with comments between them, which end as OpenCV has it.
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

// Lines of text, an empty one, then "-Y height +X width"; OpenCV cuts longer lines in two.
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

std::optional<cv::Size2d> ClaimedSize(std::istream& file) {
  std::string head(kHeadBytes, '\0');
  file.clear();
  file.seekg(0);
  file.read(head.data(), kHeadBytes);
  const auto read = file.gcount();
  file.clear();
  constexpr std::string_view kNetpbmKinds = "123456Ff";
  if (head[0] == 'P' && kNetpbmKinds.find(head[1]) != std::string_view::npos) return OfNetpbm(file);
  if (head.starts_with("#?")) return OfRadiance(file);
  constexpr std::streamsize kBmpBytes = 26;
  if (head.starts_with("BM") && read >= kBmpBytes) return OfBmp(head);
  if (read < static_cast<std::streamsize>(kHeadBytes)) return std::nullopt;
  if (head.starts_with("RIFF") && std::string_view(head).substr(8, 4) == "WEBP") return OfWebp(head);
  return std::nullopt;
}

}  // namespace ulf
