// Opens the device, or the settings of the device, that a URI names (`aravis:ID`, `v4l2:/dev/video0`,
// `gphoto2:PORT`, `sim:studio?seed=7`, `replay:PATH`), and lists what can be found.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "acquisition/device/device.h"
#include "acquisition/device/features.h"

namespace ulf::acquisition {

// Opens a device, not started, by the scheme of its URI; for an empty URI the first real camera found. Throws
// Refusal for an invalid URI, Error for a device that cannot be opened.
std::unique_ptr<Device> OpenDevice(const std::string& uri);

// Opens the features of a camera by its URI. Throws Refusal for a device without features (replay, sim).
std::unique_ptr<FeatureAccess> OpenFeatures(const std::string& uri);

// Returns every camera that can be found: real ones first, then the simulated one. Takes about a second.
std::vector<DeviceInfo> ListDevices();

}  // namespace ulf::acquisition
