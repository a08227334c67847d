// Reads files byte by byte: parts of them, numbers of either byte order, the mark before text.
#pragma once

#include <cstddef>
#include <cstdint>
#include <istream>
#include <string>
#include <string_view>

namespace ulf {

// Returns `count` bytes from the position `at` on; fewer where the file ends.
inline std::string BytesAt(std::istream& file, std::uint64_t at, std::size_t count) {
  std::string bytes(count, '\0');
  file.clear();
  file.seekg(static_cast<std::streamoff>(at));
  file.read(bytes.data(), static_cast<std::streamsize>(count));
  bytes.resize(static_cast<std::size_t>(file.gcount()));
  return bytes;
}

// Windows begins text with this mark.
inline constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";

// Goes to the beginning of a file, behind the mark if there is one.
inline void SkipByteOrderMark(std::istream& file) {
  const bool is_marked = BytesAt(file, 0, kByteOrderMark.size()) == kByteOrderMark;
  file.clear();
  file.seekg(is_marked ? static_cast<std::streamoff>(kByteOrderMark.size()) : 0);
}

// These return the unsigned number that all of `bytes` encode; there are at most eight.
inline std::uint64_t BigEndian(std::string_view bytes) {
  std::uint64_t value = 0;
  for (const char byte : bytes) value = value << 8 | static_cast<unsigned char>(byte);
  return value;
}
inline std::uint64_t LittleEndian(std::string_view bytes) {
  return BigEndian(std::string(bytes.rbegin(), bytes.rend()));
}

}  // namespace ulf
