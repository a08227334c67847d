// Webcams and frame grabbers through Video4Linux2: `v4l2:ID?option=value&...`.
//
// ID: a node (/dev/video0), a USB serial number, a bus path (usb-0000:00:14.0-1), the camera's name; empty:
// the first that can be used.
//
//   format   YUYV, UYVY, NV12, MJPEG, RGB8, Mono8, BayerRG8, ..., or the kernel's four letters    else:
//   chosen size     WxH else: chosen fps      frames a second else: the fastest at that size io       mmap,
//   or userptr: which side owns the buffers               else: mmap settle   seconds that the automatics get
//   to settle before they are switched off             else: 1 queue    frames that may wait for the reader
//   else: 4 any control by its name (v4l2_controls.h): exposure, gain, white_balance, focus, sharpness, ...
//
// Chosen means: the largest picture up to 1920x1080 at 24 frames a second or more, uncompressed before JPEG.
//
// A light field needs pictures that differ by viewpoint alone: auto exposure, gain, white balance and focus
// run until `settle` is over (a camera adapts only while it streams, so its frames until then are thrown
// away), then they are switched off and hold what they have reached; each is said as a notice, and Info().uri
// names the values from then on, so that the camera opened again by it goes on as it was. An automatic that
// is named in the URI stays as it is asked to be. Frame::exposure_s is read back from the driver, 0 while the
// camera chooses it. Drivers count gain in units of their own: Frame::gain is 1.
//
// Frame::device_time_s is the kernel's monotonic clock: the middle of the exposure where the driver stamps
// its start, that of a picture without readout time where it stamps the end. Gaps in the driver's sequence
// numbers are counted as missing; buffers that it marks as damaged, and JPEGs cut short, come as kIncomplete.
//
// The device is lost (kLost) when the camera is unplugged, at once, or when no frame has come for 5.5 s or
// ten periods, whichever is longer; Info().problem says which.
#pragma once

#include <memory>
#include <vector>

#include "acquisition/device/device.h"

namespace ulf::acquisition {

// Throws UsageError for options that make no sense or that the camera does not have, Error for the rest.
std::unique_ptr<Device> OpenV4l2Device(const DeviceUri& uri);

// At once. A camera that this user may not open says so in `problem`.
std::vector<DeviceInfo> ListV4l2Devices();

}  // namespace ulf::acquisition
