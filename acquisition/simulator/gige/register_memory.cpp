#include "acquisition/simulator/gige/register_memory.h"

#include <fmt/format.h>

#include <algorithm>

#include "acquisition/gige_vision/gvcp.h"

namespace ulf::acquisition {
namespace {

constexpr std::uint32_t kRegisterBytes = 0x10000, kDescriptionUrlAt = 0x200;

}  // namespace

RegisterMemory::RegisterMemory(std::string_view description)
    : bytes_(kRegisterBytes + (description.size() + 3) / 4 * 4) {
  std::copy(description.begin(), description.end(), bytes_.begin() + kRegisterBytes);
  Write(kDescriptionUrlAt,
        fmt::format("Local:arv-fake-camera.xml;{:x};{:x}", kRegisterBytes, description.size()));
}

std::uint32_t RegisterMemory::Read(std::uint32_t address) const {
  const MutexLock lock(mutex_);
  return gvcp::Word(&bytes_[address]);
}

void RegisterMemory::Read(std::uint32_t address, std::span<std::uint8_t> into) const {
  const MutexLock lock(mutex_);
  std::copy_n(bytes_.begin() + address, into.size(), into.begin());
}

void RegisterMemory::Write(std::uint32_t address, std::uint32_t value) {
  const MutexLock lock(mutex_);
  gvcp::PutWord(&bytes_[address], value);
}

void RegisterMemory::Write(std::uint32_t address, std::string_view text) {
  const MutexLock lock(mutex_);
  std::copy(text.begin(), text.end(), bytes_.begin() + address);
}

}  // namespace ulf::acquisition
