// Unpacks values of 10 to 16 bits as cameras pack them and spreads them over 16 bits: full scale becomes
// exactly 65535 (v * 65535 / (2^n - 1), by repeating the high bits), which is monotone and reversible.
// `count` values from `bytes` to `out`; four at a time in a 64-bit word.
#pragma once

#include <cstddef>
#include <cstdint>

namespace ulf {

// PFNC's "p": a stream of bits, lowest first. `bits` 10, 12 or 14.
void UnpackLsb(const std::uint8_t* bytes, std::size_t count, int bits, std::uint16_t* out);

// GigE Vision's "Packed": two values in three bytes, the low bits of both in the middle one. `bits` 10 or 12.
void UnpackGvsp(const std::uint8_t* bytes, std::size_t count, int bits, std::uint16_t* out);

// 16-bit little-endian words with the value in the low bits; the bits above are ignored.
void UnpackWords(const std::uint8_t* bytes, std::size_t count, int bits, std::uint16_t* out);

}  // namespace ulf
