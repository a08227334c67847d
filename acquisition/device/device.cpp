#include "acquisition/device/device.h"

#include <array>

namespace ulf::acquisition {

const char* Name(DeviceState state) {
  constexpr std::array kNames{"connected", "streaming", "faulted", "reconnecting", "ended", "lost"};
  return kNames[static_cast<std::size_t>(state)];
}

const char* Name(DeviceEventKind kind) {
  constexpr std::array kNames{"stalled", "faulted", "reconnecting", "restored", "notice"};
  return kNames[static_cast<std::size_t>(kind)];
}

}  // namespace ulf::acquisition
