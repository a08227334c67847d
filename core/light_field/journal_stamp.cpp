#include "core/light_field/journal_stamp.h"

#include <zlib.h>

#include <algorithm>
#include <fstream>
#include <vector>

namespace ulf {

namespace fs = std::filesystem;

std::optional<JournalStamp> StampOf(const fs::path& file, std::uint64_t bytes) {
  std::ifstream stream(file, std::ios::binary);
  JournalStamp stamp{bytes, 0};
  std::vector<char> part(1 << 16);
  for (std::uint64_t left = bytes; left > 0;) {
    const auto size = static_cast<std::streamsize>(std::min<std::uint64_t>(left, part.size()));
    if (!stream.read(part.data(), size)) return std::nullopt;
    stamp.crc32 = static_cast<std::uint32_t>(
        ::crc32(stamp.crc32, reinterpret_cast<const Bytef*>(part.data()), static_cast<uInt>(size)));
    left -= static_cast<std::uint64_t>(size);
  }
  if (!stream) return std::nullopt;
  return stamp;
}

std::optional<JournalStamp> StampOf(const fs::path& file) {
  std::error_code missing;
  const std::uint64_t bytes = fs::file_size(file, missing);
  return missing ? std::nullopt : StampOf(file, bytes);
}

}  // namespace ulf
