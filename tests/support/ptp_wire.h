// Defines PTP's numbers as they stand on the wire, little endian: codes of ISO 15740 and PTP/IP, and Nikon's
// for live view.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tests/support/floors.h"

namespace ulf::test::ptp {

// Packet types of PTP/IP.
enum Packet : std::uint32_t {
  kInitCommand = 1,
  kInitCommandAck = 2,
  kInitEvent = 3,
  kInitEventAck = 4,
  kInitFail = 5,
  kRequest = 6,
  kResponse = 7,
  kEvent = 8,
  kStartData = 9,
  kData = 10,
  kEndData = 12,
};

enum Response : std::uint16_t {
  kOk = 0x2001,
  kNotSupported = 0x2005,
  kGeneralError = 0x2002,
  kBadObject = 0x2009,
  kBadProperty = 0x200A,
  kStoreFull = 0x200C,
  kReadOnly = 0x200F,
  kBusy = 0x2019,
};

enum Operation : std::uint16_t {
  kGetDeviceInfo = 0x1001,
  kOpenSession = 0x1002,
  kCloseSession = 0x1003,
  kGetStorageIds = 0x1004,
  kGetStorageInfo = 0x1005,
  kGetNumObjects = 0x1006,
  kGetObjectHandles = 0x1007,
  kGetObjectInfo = 0x1008,
  kGetObject = 0x1009,
  kDeleteObject = 0x100B,
  kInitiateCapture = 0x100E,
  kGetPropertyDescription = 0x1014,
  kGetProperty = 0x1015,
  kSetProperty = 0x1016,
  // Nikon's
  kDeviceReady = 0x90C8,
  kStartLiveView = 0x9201,
  kEndLiveView = 0x9202,
  kGetLiveView = 0x9203,
};

inline constexpr std::uint32_t kStorage = 0x10001;
inline constexpr std::uint16_t kLiveViewStatus = 0xD1A2;
inline constexpr std::uint32_t kNikon = 0x0000000A;
inline constexpr std::uint16_t kObjectAdded = 0x4002, kPropertyChanged = 0x4006, kStoreFullEvent = 0x400A,
                               kCaptureComplete = 0x400D;

template <typename T>
void Put(std::string& out, T value) {
  for (std::size_t i = 0; i < sizeof(T); ++i)
    out.push_back(static_cast<char>(static_cast<std::uint64_t>(value) >> (8 * i) & 0xFF));
}

// `type`: PTP's data type: 2, 4 and 6 are unsigned numbers of 8, 16 and 32 bits.
inline void PutNumber(std::string& out, std::uint16_t type, std::uint32_t value) {
  if (type == 2) Put<std::uint8_t>(out, static_cast<std::uint8_t>(value));
  if (type == 4) Put<std::uint16_t>(out, static_cast<std::uint16_t>(value));
  if (type == 6) Put<std::uint32_t>(out, value);
}

// Writes ASCII as PTP's counted UTF-16.
inline void PutText(std::string& out, const std::string& text) {
  if (text.empty()) {
    Put<std::uint8_t>(out, 0);
    return;
  }
  Put<std::uint8_t>(out, static_cast<std::uint8_t>(text.size() + 1));
  for (const char c : text) Put<std::uint16_t>(out, static_cast<std::uint8_t>(c));
  Put<std::uint16_t>(out, 0);
}

template <typename T>
void PutArray(std::string& out, const std::vector<T>& values) {
  Put<std::uint32_t>(out, static_cast<std::uint32_t>(values.size()));
  for (const T value : values) Put(out, value);
}

// Bytes beyond the end count as 0.
template <typename T>
T Get(const std::string& from, std::size_t at) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < sizeof(T) && at + i < from.size(); ++i)
    value |= static_cast<std::uint64_t>(static_cast<std::uint8_t>(from[at + i])) << (8 * i);
  return static_cast<T>(value);
}

}  // namespace ulf::test::ptp
