// Which machine-vision cameras are there, and which one an `aravis:` URI means.
#pragma once

#include <string>
#include <vector>

#include "acquisition/device/device.h"

namespace ulf::acquisition {

// What the library opens for the ID of a URI (aravis_device.h tells what an ID may be): at once for an
// address, after a second of discovery for anything else. Throws Error with what was found instead.
std::string ResolveAravis(const std::string& uri, const std::string& id);

// Every camera on every network and USB port: about a second. One that cannot be opened says why in
// `problem`, with the way out: another program controls it (and whose, where the camera tells), it sits in
// another network, this user may not open the USB device.
std::vector<DeviceInfo> ListAravisDevices();

}  // namespace ulf::acquisition
