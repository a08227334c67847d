#include "core/image/files/picture_end.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <string>
#include <system_error>

#include "core/base/atomic_file.h"
#include "core/base/binary_file.h"

namespace ulf {
namespace {

constexpr std::string_view kPngSignature = "\x89PNG\r\n\x1A\n", kJpegStart = "\xFF\xD8";

unsigned Byte(std::string_view bytes, std::size_t at) { return static_cast<std::uint8_t>(bytes[at]); }

constexpr unsigned kEndOfImage = 0xD9, kStartOfScan = 0xDA;

// Returns the step past bytes without a segment length, or zero at a segment. Decoders ignore bytes before a
// marker, fill bytes, and markers without a length (restarts, the start, and TEM).
std::size_t StepWithoutLength(unsigned first, unsigned marker) {
  if (first != 0xFF || marker == 0xFF) return 1;
  return (marker >= 0xD0 && marker <= 0xD8) || marker <= 0x01 ? 2 : 0;
}

// Returns the place of the next marker at or after `at` in coded data: 0xFF, not followed by a stuffed zero
// or a restart.
std::size_t NextMarker(std::string_view bytes, std::size_t at) {
  while (at + 1 < bytes.size()) {
    const void* found = std::memchr(bytes.data() + at, 0xFF, bytes.size() - at - 1);
    if (!found) break;
    at = static_cast<std::size_t>(static_cast<const char*>(found) - bytes.data());
    const unsigned next = Byte(bytes, at + 1);
    if (next != 0 && next != 0xFF && !(next >= 0xD0 && next <= 0xD7)) return at;
    at += next == 0xFF ? 1 : 2;
  }
  return bytes.size();
}

bool PngIsWhole(std::ifstream& file, std::uint64_t size) {
  constexpr std::uint64_t kLengthNameSum = 12;
  std::uint64_t at = kPngSignature.size();
  while (at + kLengthNameSum <= size) {
    const std::string head = BytesAt(file, at, 8);
    if (head.size() < 8) return false;
    at += kLengthNameSum + BigEndian(head.substr(0, 4));
    if (head.substr(4) == "IEND") return at <= size;
  }
  return false;
}

// Returns where the first scan begins, by steps from segment to segment; zero if the file ends before.
std::uint64_t FirstScan(std::ifstream& file, std::uint64_t size) {
  std::uint64_t at = kJpegStart.size();
  while (at + 4 <= size) {
    const std::string head = BytesAt(file, at, 4);
    if (head.size() < 4) return 0;
    const unsigned marker = Byte(head, 1);
    if (const std::size_t step = StepWithoutLength(Byte(head, 0), marker); step > 0) {
      at += step;
      continue;
    }
    if (marker == kEndOfImage) return 0;
    at += 2 + BigEndian(head.substr(2));
    if (marker == kStartOfScan) return at < size ? at : 0;
  }
  return 0;
}

}  // namespace

bool JpegIsWhole(std::string_view bytes) {
  if (!bytes.starts_with(kJpegStart)) return false;
  std::size_t at = kJpegStart.size();
  while (at + 1 < bytes.size()) {
    const unsigned marker = Byte(bytes, at + 1);
    if (const std::size_t step = StepWithoutLength(Byte(bytes, at), marker); step > 0) {
      at += step;
      continue;
    }
    if (marker == kEndOfImage) return true;
    if (at + 4 > bytes.size()) return false;
    at += 2 + BigEndian(bytes.substr(at + 2, 2));
    if (marker == kStartOfScan) at = NextMarker(bytes, std::min(at, bytes.size()));
  }
  return false;
}

bool ImageFileIsWhole(const std::filesystem::path& path) {
  std::error_code unknown;
  if (!std::filesystem::is_regular_file(path, unknown)) return false;
  std::ifstream file(path, std::ios::binary);
  const std::uintmax_t size = std::filesystem::file_size(path, unknown);
  const std::string head = BytesAt(file, 0, kPngSignature.size());
  if (unknown || head.size() < kPngSignature.size()) return false;
  if (head == kPngSignature) return PngIsWhole(file, size);
  if (!head.starts_with(kJpegStart)) return true;
  // Coded data hold no end mark: one behind the start of the first scan is the picture's own, or lies behind
  // that. The search starts at the end of the file, where nearly all have it.
  const std::uint64_t scan = FirstScan(file, size);
  if (scan == 0) return false;
  constexpr std::uint64_t kTail = 4096;
  const std::size_t tail_size = std::min<std::uint64_t>(kTail, size - scan);
  const std::string tail = BytesAt(file, size - tail_size, tail_size);
  if (tail.find("\xFF\xD9") != std::string::npos) return true;
  return JpegIsWhole(ReadWholeFile(path));
}

}  // namespace ulf
