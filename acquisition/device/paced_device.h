// Plays a recording in time, as a live camera: frames arrive at the intervals at which they were taken,
// `speed` times as fast, whether or not Next() is called. Up to four frames wait for a slow reader (as the
// cameras' default `queue`); then the oldest is dropped and counted. Photographs keep their place and are
// never dropped.
#pragma once

#include <memory>

#include "acquisition/device/device.h"

namespace ulf::acquisition {

// `recording`: a device whose IsLive() is false, not started.
std::unique_ptr<Device> MakePacedDevice(std::unique_ptr<Device> recording, double speed);

}  // namespace ulf::acquisition
