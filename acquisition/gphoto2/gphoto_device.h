// Opens a tethered camera, with live view and photographs: `gphoto2:ID`.
//
// ID names a port, an address in the network, a model or a serial number. What it may be, and the options,
// are those of docs/devices.md#tethered-cameras-gphoto2.
//
// Live view is delivered as FrameKind::kLive; the newest `queue` frames (default 4) wait for the reader,
// older ones are dropped and counted. A photograph is delivered as FrameKind::kStill after its download,
// whether the program or the photographer released the shutter; photographs are never dropped. Its JPEG is
// kept byte for byte (Frame::encoded), and so is a raw file of the same name (Frame::raw). Next() develops a
// raw file alone, quickly, to linear light; one that LibRaw cannot read is kIncomplete.
//
// Times are those of the host's clock, because these cameras' clocks are readable to a second only. A live
// frame has the time of its arrival. A photograph has the time at which the program released the shutter
// (Frame::requested_s) plus `shutter_lag_ms` (default 0); one released on the body has the time at which the
// camera announced it. Exposure and gain of a live frame are unknown (0 and 1). Those of a photograph come
// from its Exif, else from the camera's settings; gain 1 is ISO 100.
//
// When the link drops, photographs stay on the camera's card: those that it announced and that were not
// downloaded, and those that it takes until it is opened again. A device that is opened with the same
// UnfetchedPhotographs as the lost one (`left`; null: a new list) fetches them.
#pragma once

#include <memory>
#include <vector>

#include "acquisition/device/device.h"
#include "acquisition/device/features.h"
#include "acquisition/gphoto2/unfetched_photographs.h"

namespace ulf::acquisition {

// Throws Refusal for unknown options and values that the camera does not offer, Error if it cannot be opened.
std::unique_ptr<Device> OpenGphotoDevice(const DeviceUri& uri,
                                         std::shared_ptr<UnfetchedPhotographs> left = nullptr);

// Opens the camera's configuration tree. Throws as OpenGphotoDevice().
std::unique_ptr<FeatureAccess> OpenGphotoFeatures(const DeviceUri& uri);

// Lists the cameras at USB ports; where one cannot be opened, DeviceInfo::problem says why.
std::vector<DeviceInfo> ListGphotoDevices();

}  // namespace ulf::acquisition
