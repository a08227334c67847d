#include "core/video/container_end.h"

#include <fmt/core.h>

#include <cstdint>
#include <fstream>
#include <optional>
#include <string_view>

#include "core/base/binary_file.h"

namespace ulf {
namespace {

namespace fs = std::filesystem;

struct Container {
  std::ifstream stream;
  std::uint64_t size = 0;
  // Returns bytes from `at` on; fewer at the end of the file.
  std::string At(std::uint64_t at, std::size_t count) { return BytesAt(stream, at, count); }
};

std::string Short(std::uint64_t there, std::uint64_t named) {
  return fmt::format("its end is missing: {:.4g} of {:.4g} MB are there", 1e-6 * static_cast<double>(there),
                     1e-6 * static_cast<double>(named));
}

// ISO/IEC 14496-12 has boxes of a size (32 bits, or 64 behind a 1; 0: to the end of the file) and a name.
std::string MissingInBoxes(Container& file) {
  constexpr int kMostBoxes = 100'000;  // for a fragmented file. Guessed.
  bool has_index = false;
  std::uint64_t at = 0;
  for (int box = 0; box < kMostBoxes && at + 8 <= file.size; ++box) {
    const std::string head = file.At(at, 16);
    if (head.size() < 8) break;
    std::uint64_t size = BigEndian(head.substr(0, 4));
    if (size == 1 && head.size() == 16) size = BigEndian(head.substr(8));
    if (size == 0) size = file.size - at;
    const std::string name = head.substr(4, 4);
    has_index = has_index || name == "moov";
    if (size < 8) return {};  // invalid: the reader reports it
    if (size > file.size - at)
      return Short(file.size, at + size) + (has_index ? "" : ", and with it the index ('moov')");
    at += size;
  }
  return has_index ? ""
                   : "its index ('moov') is missing, which is written last: the recording was not closed";
}

// A number of EBML (RFC 8794) at the beginning of `bytes`, and its length; none if it is truncated. All ones
// mean unknown.
struct EbmlNumber {
  std::uint64_t value = 0;
  std::size_t length = 0;
  bool is_known = true;
};
std::optional<EbmlNumber> NumberIn(std::string_view bytes) {
  if (bytes.empty() || bytes[0] == '\0') return std::nullopt;
  const auto first = static_cast<unsigned char>(bytes[0]);
  std::size_t length = 1;
  while (((first << (length - 1)) & 0x80) == 0) ++length;
  if (bytes.size() < length) return std::nullopt;
  const std::uint64_t ones = (std::uint64_t{1} << (7 * length)) - 1;
  const std::uint64_t value = BigEndian(bytes.substr(0, length)) & ones;
  return EbmlNumber{value, length, value != ones};
}

// Matroska has a header, then one segment that holds all.
std::string MissingInSegment(Container& file) {
  constexpr std::string_view kSegment("\x18\x53\x80\x67", 4);
  const auto header = NumberIn(file.At(4, 8));
  if (!header || !header->is_known) return {};
  const std::uint64_t at = 4 + header->length + header->value;
  const std::string head = file.At(at, 12);
  if (!head.starts_with(kSegment)) return {};
  const auto size = NumberIn(std::string_view(head).substr(kSegment.size()));
  if (!size || !size->is_known) return {};
  const std::uint64_t end = at + kSegment.size() + size->length + size->value;
  return end > file.size ? Short(file.size, end) : std::string();
}

std::string MissingInRiff(Container& file) {
  const std::string size = file.At(4, 4);
  if (size.size() < 4) return {};
  const std::uint64_t end = 8 + LittleEndian(size);
  constexpr std::uint64_t kEmpty = 8;  // in a recording that was not closed
  return end > file.size && end > kEmpty ? Short(file.size, end) : std::string();
}

}  // namespace

std::string MissingEnd(const fs::path& path) {
  std::error_code unknown;
  const std::uintmax_t size = fs::file_size(path, unknown);
  Container file{std::ifstream(path, std::ios::binary), unknown ? 0 : size};
  const std::string head = file.At(0, 12);
  if (head.size() < 12) return {};
  const std::string_view box = std::string_view(head).substr(4, 4);
  if (box == "ftyp" || box == "moov" || box == "mdat" || box == "wide") return MissingInBoxes(file);
  if (head.starts_with("\x1A\x45\xDF\xA3")) return MissingInSegment(file);
  if (head.starts_with("RIFF") && head.ends_with("AVI ")) return MissingInRiff(file);
  return {};
}

}  // namespace ulf
