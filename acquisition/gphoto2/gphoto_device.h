// `gphoto2:ID`: a tethered camera, live view and photographs.
//
//   gphoto2:                          the first camera at a USB port
//   gphoto2:usb:001,005               the one at this port ('ulf devices' lists them)
//   gphoto2:ptpip:192.168.1.9         over the network (PTP/IP; with another port: ptpip:ADDRESS:PORT)
//   gphoto2:NAME                      by model, or by serial number
//   ?shutter=1/125&iso=200&aperture=8&focus=manual&imageformat=...&target=card|ram&liveview_fps=15
//    &shutter_lag_ms=120&queue=4
//
// Live view comes as frames of FrameKind::kLive; the newest wait in a queue of `queue`, older ones are
// dropped and counted. A photograph, whoever released the shutter, comes as FrameKind::kStill when it has
// been downloaded; photographs are never dropped. Its JPEG is kept byte for byte (Frame::encoded), a raw file
// of the same name beside it (Frame::raw). A camera set to raw only gives stills without pixels, marked
// incomplete: nothing here decodes raw.
//
// Times are the host's clock: these cameras have none that can be read to better than a second. A live
// frame's is its arrival. A photograph's is the moment at which the shutter was asked to open, plus
// `shutter_lag_ms` where that is given (Frame::requested_s is the request itself); where it was released on
// the body, the moment at which the camera announced it. A live frame's exposure and gain are unknown (0 and
// 1): live view has its own. A photograph's come from its Exif, else from the camera's settings; gain 1 is
// ISO 100.
#pragma once

#include <memory>
#include <vector>

#include "acquisition/device/device.h"
#include "acquisition/device/features.h"

namespace ulf::acquisition {

// Throws UsageError for unknown options and values that the camera does not offer, Error for a camera that
// cannot be opened.
std::unique_ptr<Device> OpenGphotoDevice(const DeviceUri& uri);

// The camera's configuration tree by name.
std::unique_ptr<FeatureAccess> OpenGphotoFeatures(const DeviceUri& uri);

// Cameras at USB ports.
std::vector<DeviceInfo> ListGphotoDevices();

}  // namespace ulf::acquisition
