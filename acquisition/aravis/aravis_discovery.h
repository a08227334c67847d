// Finds machine-vision cameras, and the one that an `aravis:` URI names.
#pragma once

#include <string>
#include <vector>

#include "acquisition/device/device.h"

namespace ulf::acquisition {

// The id that the library opens for the ID of a URI (aravis_device.h lists what an ID may be): at once for an
// address, after a second of discovery for anything else. Throws Error that lists the cameras found.
std::string ResolveAravis(const std::string& uri, const std::string& id);

// Every camera on every network and USB port; takes about a second. Where a camera cannot be opened,
// `problem` says why and what to do: another program controls it (which one, where the camera tells), it is
// in another network, or this user may not open the USB device.
std::vector<DeviceInfo> ListAravisDevices();

}  // namespace ulf::acquisition
