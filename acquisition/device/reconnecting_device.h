// Implements the state machine of device.h for all drivers: finds a lost camera and opens it again.
//
// A driver reports kLost and the reason (Info().problem). Frames that wait in it are still delivered; then
// the device is kFaulted, and from the next call of Next() on kReconnecting: a thread (driver_search.h) opens
// a driver again, alternately at the camera's old address and at any other, until one delivers a frame. It
// must be the same camera, with images of the same size and kind; any other is refused, with an event.
// Opening writes all settings again. After Reconnection::patience_s the device is kLost.
//
// Across a gap statistics are added up and device_time_s continues. A camera that was switched off restarts
// its clock: then its times are shifted so that the gap is as long as on this computer's clock, and the event
// names the shift. Frame ids are the camera's own and may restart.
//
// Next(), Start() and Stop() belong to one thread; all other functions may be called from any. No call waits
// for a camera that is gone: lost drivers are closed in the background.
#pragma once

#include <memory>

#include "acquisition/device/device.h"
#include "acquisition/device/driver_search.h"

namespace ulf::acquisition {

// `driver`: open, not started.
std::unique_ptr<Device> MakeReconnectingDevice(std::unique_ptr<Device> driver, Reconnection reconnection);

}  // namespace ulf::acquisition
