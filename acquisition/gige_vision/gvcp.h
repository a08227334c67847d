// Encodes the GigE Vision control protocol (GVCP): a header of eight bytes, then the payload, all big-endian.
// Headers have these fields, with their bytes in parentheses:
//
//   request  key 0x42 (1), flags (1), command (2), bytes of the payload (2), number of the request (2)
//   answer   status (2), command + 1 (2), bytes of the payload (2), number of the request (2)
#pragma once

#include <cstddef>
#include <cstdint>

namespace ulf::acquisition::gvcp {

inline constexpr std::size_t kHeaderBytes = 8;

enum Command : std::uint16_t {
  kDiscovery = 0x02,
  kDiscoveryAck = 0x03,
  kResend = 0x40,
  kReadRegister = 0x80,
  kReadRegisterAck = 0x81,
  kWriteRegister = 0x82,
  kReadMemory = 0x84,
  kWriteMemory = 0x86
};

// Addresses of the standard's bootstrap registers. A discovery answer holds the first kDiscoveryBytes.
inline constexpr std::uint32_t kCurrentAddressAt = 0x24, kNetmaskAt = 0x34, kMakerAt = 0x48, kModelAt = 0x68,
                               kVersionAt = 0x88, kInfoAt = 0xA8, kSerialAt = 0xD8, kUserNameAt = 0xE8,
                               kDiscoveryBytes = 0xF8, kHeartbeatTimeoutAt = 0x938,
                               kControlPrivilegeAt = 0xA00, kControllerPortAt = 0xA04,
                               kControllerAddressAt = 0xA14;

inline std::uint16_t Half(const std::uint8_t* at) { return static_cast<std::uint16_t>(at[0] << 8 | at[1]); }
inline std::uint32_t Word(const std::uint8_t* at) {
  return static_cast<std::uint32_t>(Half(at)) << 16 | Half(at + 2);
}
inline void PutHalf(std::uint8_t* at, std::uint32_t value) {
  at[0] = static_cast<std::uint8_t>(value >> 8);
  at[1] = static_cast<std::uint8_t>(value);
}
inline void PutWord(std::uint8_t* at, std::uint32_t value) {
  PutHalf(at, value >> 16);
  PutHalf(at + 2, value);
}

}  // namespace ulf::acquisition::gvcp
