#include "core/light_field/formats/image_names.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <utility>

#include "core/geometry/digest.h"

namespace ulf {
namespace {

namespace fs = std::filesystem;

// A file system takes 255 bytes; the rest is for endings and numbers of files made from the image.
constexpr std::size_t kMostBytes = 200;

bool IsWhiteSpace(std::uint32_t point) {
  constexpr std::array<std::uint32_t, 7> kAlone = {0x85, 0xA0, 0x1680, 0x2028, 0x2029, 0x202F, 0x205F};
  return point <= ' ' || point == 0x7F || (point >= 0x80 && point < 0xA0) ||
         (point >= 0x2000 && point <= 0x200B) || point == 0x3000 || point == 0xFEFF ||
         std::ranges::find(kAlone, point) != kAlone.end();
}

// Returns the code point that begins at `at` and its number of bytes; none if the bytes are not UTF-8.
std::pair<std::uint32_t, std::size_t> CodePoint(std::string_view text, std::size_t at) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned char first = byte(at);
  const std::size_t length = first < 0x80       ? 1
                             : first >> 5 == 6  ? 2
                             : first >> 4 == 14 ? 3
                             : first >> 3 == 30 ? 4
                                                : 0;
  if (length == 0 || at + length > text.size()) return {0, 0};
  if (length == 1) return {first, 1};
  std::uint32_t point = first & (0xFFu >> (length + 1));
  for (std::size_t i = 1; i < length; ++i) {
    if (byte(at + i) >> 6 != 2) return {0, 0};
    point = point << 6 | (byte(at + i) & 0x3Fu);
  }
  constexpr std::array<std::uint32_t, 5> kLeast = {0, 0, 0x80, 0x800, 0x10000};
  const bool is_surrogate = point >= 0xD800 && point <= 0xDFFF;
  if (point < kLeast[length] || is_surrogate || point > 0x10FFFF) return {0, 0};
  return {point, length};
}

std::string Shortened(const fs::path& path) {
  const std::string name = path.filename().string(), ending = path.extension().string();
  if (name.size() <= kMostBytes) return path.generic_string();
  const std::string digest = fmt::format("-{:016x}{}", ChecksumOf(name), ending.size() > 16 ? "" : ending);
  std::size_t kept = kMostBytes - digest.size();
  while (kept > 0 && static_cast<unsigned char>(name[kept]) >> 6 == 2) --kept;  // do not split a character
  return (path.parent_path() / (name.substr(0, kept) + digest)).generic_string();
}

}  // namespace

std::string NameInImagesFolder(std::string_view image_path) {
  constexpr std::string_view kFolder = "images/";
  return std::string(image_path.starts_with(kFolder) ? image_path.substr(kFolder.size()) : image_path);
}

std::string SafeName(std::string_view name) {
  std::string safe;
  for (std::size_t at = 0; at < name.size();) {
    const auto [point, length] = CodePoint(name, at);
    if (length == 0 || IsWhiteSpace(point))
      safe += '_';
    else
      safe += name.substr(at, length);
    at += std::max<std::size_t>(length, 1);
  }
  return safe;
}

std::string UniqueName(const std::string& name, std::set<std::string>& taken) {
  const fs::path whole = Shortened(name);
  fs::path unique = whole;
  for (int number = 2; !taken.insert(fs::path(unique).replace_extension().generic_string()).second; ++number)
    unique = whole.parent_path() /
             fmt::format("{}-{}{}", whole.stem().string(), number, whole.extension().string());
  return unique.generic_string();
}

}  // namespace ulf
