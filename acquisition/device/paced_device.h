// A recording played in time, as a live camera would be: frames come when they were taken, `speed` times as
// fast, whether or not they are asked for. Four wait for a slow reader; then the oldest goes, and is counted.
// Photographs come where they came, and are never dropped.
#pragma once

#include <memory>

#include "acquisition/device/device.h"

namespace ulf::acquisition {

// `recording` is a device whose frames wait (IsLive() false), not started.
std::unique_ptr<Device> MakePacedDevice(std::unique_ptr<Device> recording, double speed);

}  // namespace ulf::acquisition
