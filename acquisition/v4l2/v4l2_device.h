// Opens webcams and frame grabbers through Video4Linux2: `v4l2:ID?option=value&...`.
//
// ID: a node (/dev/video0), a USB serial number, a bus path (usb-0000:00:14.0-1) or the camera's name; empty:
// the first camera that can be opened.
//
// The options, and what is chosen without them, are those of docs/devices.md#webcams-and-frame-grabbers-v4l2.
//
// The pictures of a light field may differ by viewpoint only. Auto exposure, gain, white balance and focus
// run for `settle` seconds; frames until then are discarded. Then the device switches the automatics off, and
// they keep the values that they have reached. It reports each as a notice, and Info().uri contains the
// values from then on, so that a camera opened again by that URI continues with them. An automatic that the
// URI names stays as the URI sets it. Frame::exposure_s is read back from the driver, 0 while exposure is
// automatic. Frame::gain is 1, because the unit of a driver's gain is unknown.
//
// Frame::device_time_s is the kernel's monotonic clock at the middle of the exposure, computed from the
// driver's time stamp (start of exposure or end of frame; the readout time is unknown and neglected). Gaps in
// the driver's sequence numbers count as missing. Buffers that the driver marks as damaged, and truncated
// JPEGs, are delivered as kIncomplete.
//
// The device is lost (kLost) at once when the camera is unplugged, or when no frame has arrived for 5.5 s or
// ten periods, whichever is longer; Info().problem says which.
#pragma once

#include <memory>
#include <vector>

#include "acquisition/device/device.h"
#include "acquisition/device/features.h"

namespace ulf::acquisition {

// Throws Refusal for options that are invalid or unknown to the camera, Error for other failures.
std::unique_ptr<Device> OpenV4l2Device(const DeviceUri& uri);

// Returns all webcams, without waiting. A camera that this user may not open has the reason in `problem`.
std::vector<DeviceInfo> ListV4l2Devices();

// Opens a webcam's controls as features, for `ulf features`: named as v4l2-ctl names them (the short names of
// v4l2_controls.h are accepted too) and grouped as in the driver. It works while others stream, too.
std::unique_ptr<FeatureAccess> OpenV4l2Features(const DeviceUri& uri);

}  // namespace ulf::acquisition
