#include "acquisition/device/device.h"

#include <array>

#include "core/base/error.h"

namespace ulf::acquisition {

const char* Name(DeviceState state) {
  constexpr std::array kNames{"connected", "streaming", "faulted", "reconnecting", "ended", "lost"};
  return kNames[static_cast<std::size_t>(state)];
}

const char* Name(DeviceEventKind kind) {
  constexpr std::array kNames{"stalled", "faulted", "reconnecting", "restored", "notice"};
  return kNames[static_cast<std::size_t>(kind)];
}

void RequireLiveFrames(const Device& device) {
  if (device.HasLiveFrames()) return;
  const std::string uri = device.Info().uri;
  if (IsTaken(device.Source()))
    throw Error(
        "{}: holds photographs alone, and no live frames to follow; pose the photographs together (COLMAP), "
        "and bring them in by ulf import",
        uri);
  throw Error(
      "{}: this camera has no live view to follow; take the photographs first (ulf record {} -o SHOTS keeps "
      "each that you release), pose them together (COLMAP), and bring them in by ulf import",
      uri, uri);
}

}  // namespace ulf::acquisition
