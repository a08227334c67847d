// Holds the memory of a GigE Vision camera: 64 KiB of registers, and behind them its GenICam description,
// whose place stands as text in the registers from 0x200 on. Registers have four bytes and are big-endian, as
// the control protocol sends them.
//
// All functions may be called from any thread. What is read or written must lie within Bytes().
#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "core/base/mutex.h"

namespace ulf::acquisition {

class RegisterMemory {
 public:
  // All registers but those from 0x200 on are zero.
  explicit RegisterMemory(std::string_view description);

  std::uint32_t Bytes() const { return static_cast<std::uint32_t>(bytes_.size()); }  // a multiple of four
  std::uint32_t Read(std::uint32_t address) const;
  void Read(std::uint32_t address, std::span<std::uint8_t> into) const;
  void Write(std::uint32_t address, std::uint32_t value);
  void Write(std::uint32_t address, std::string_view text);

 private:
  mutable Mutex mutex_;
  std::vector<std::uint8_t> bytes_;  // its size never changes; mutex_ guards what is in it
};

}  // namespace ulf::acquisition
