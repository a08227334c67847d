// A live camera that is looked for and opened again when it goes away: the one state machine of device.h,
// whatever the driver behind it.
//
// A driver reports kLost and why (Info().problem). Frames that wait in it are still handed out; then the
// device is kFaulted, and from the next Next() on kReconnecting: a thread of its own opens a driver again,
// alternately where the camera was and wherever it is now (it may come back at another address), until one
// delivers a frame. Only the same camera will do, with images of the same size and kind; anything else is
// refused, and that is said. Opening writes all settings again. After the patience the device is kLost.
//
// What stays the same over a gap: statistics add up; device_time_s goes on. A camera that was switched off
// begins to count anew: then its times are moved so that the gap is as long as it was by this computer's
// clock, and the event says by how much. Frame ids are the camera's own and may begin anew.
//
// Next(), Start() and Stop() belong to one thread; State(), Info(), Statistics() and TakeEvents() may be
// called from any. No call waits for a camera that is gone: dead drivers are closed in the background.
#pragma once

#include <functional>
#include <memory>

#include "acquisition/device/device.h"

namespace ulf::acquisition {

// Opens a driver anew, not started; `known` is what Info() said of the one that was lost. Throws Error.
// Called in another thread.
using ReopenDriver = std::function<std::unique_ptr<Device>(const DeviceInfo& known)>;

struct Reconnection {
  ReopenDriver where_it_was;
  ReopenDriver elsewhere;                            // wherever it is now; none: only where it was
  double patience_s = 300;                           // 0: not at all
  double first_wait_s = 0.1, longest_wait_s = 0.75;  // between two attempts, doubling
};

// `driver`: open, not started.
std::unique_ptr<Device> MakeReconnectingDevice(std::unique_ptr<Device> driver, Reconnection reconnection);

}  // namespace ulf::acquisition
