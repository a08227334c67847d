#include "core/frames/unpack.h"

#include <bit>
#include <cstring>

namespace ulf {
namespace {

static_assert(std::endian::native == std::endian::little, "words of pixels are loaded as they lie in memory");

constexpr std::uint64_t FourTimes(std::uint64_t lane) { return lane * 0x0001'0001'0001'0001u; }

std::uint16_t SpreadTo16(std::uint32_t value, int bits) {
  value &= (1u << bits) - 1;
  return static_cast<std::uint16_t>((value << (16 - bits)) | (value >> (2 * bits - 16)));
}

// The same on four 16-bit lanes.
template <int kBits>
std::uint64_t SpreadLanes(std::uint64_t values) {
  constexpr std::uint64_t kLowBits = FourTimes((1u << (16 - kBits)) - 1);
  return (values << (16 - kBits)) | ((values >> (2 * kBits - 16)) & kLowBits);
}

// Four values that follow each other in a stream of bits, one in each lane.
template <int kBits>
std::uint64_t LanesOfStream(std::uint64_t stream) {
  constexpr std::uint64_t kPair = (std::uint64_t{1} << (2 * kBits)) - 1;
  constexpr std::uint64_t kValue = (std::uint64_t{1} << kBits) - 1;
  constexpr std::uint64_t kEven = kValue | kValue << 32;
  const std::uint64_t pairs = (stream & kPair) | ((stream & (kPair << (2 * kBits))) << (32 - 2 * kBits));
  return (pairs & kEven) | ((pairs & (kEven << kBits)) << (16 - kBits));
}

// Two triples of bytes, each a high byte, the low bits of both, a high byte: one value in each lane.
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

// Whole groups of four values in kGroupBytes bytes, as long as eight can be read. Returns the values done.
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
