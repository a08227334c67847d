// `sim:SCENE`: the simulated camera as a device. Frames wait to be taken and simulated time advances by one
// period each, so that whoever reads it sees the same sequence however slow it is. For a camera that does not
// wait, serve it with `ulf simulate` and open it by `aravis:`.
#pragma once

#include <memory>

#include "acquisition/device.h"

namespace ulf {

// Throws UsageError for an unknown scene or option.
std::unique_ptr<Device> OpenSimulatedDevice(const DeviceUri& uri);

}  // namespace ulf
