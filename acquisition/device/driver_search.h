// Searches for a lost camera in a separate thread and opens a driver for it, alternately at its old address
// and at any other, until the same camera streams again or the time is over.
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <string>

#include "acquisition/device/device.h"
#include "core/base/mutex.h"

namespace ulf::acquisition {

// Opens a driver again, not started. `known`: Info() of the lost one. Throws Error.
using ReopenDriver = std::function<std::unique_ptr<Device>(const DeviceInfo& known)>;

struct Reconnection {
  ReopenDriver where_it_was;
  ReopenDriver elsewhere;  // looks for the camera by its serial number or model; none: only where it was
  // How long the camera is searched for; 0: not at all. Guessed: time to change a cable or a battery.
  double patience_s = 300;
};

// The state shared by the thread that searches and the device that waits, which may give up first.
struct DriverSearch {
  Mutex mutex;
  ConditionVariable changed;
  bool stop ULF_GUARDED_BY(mutex) = false;              // set by the device when it no longer waits
  bool over ULF_GUARDED_BY(mutex) = false;              // the time is over, and no camera was found
  std::unique_ptr<Device> found ULF_GUARDED_BY(mutex);  // the same camera, started
  std::string problem ULF_GUARDED_BY(mutex);            // of the last attempt
  std::string refused ULF_GUARDED_BY(mutex);  // why another camera was refused; empty: none was found
};

// The longest pause between two attempts. Guessed: an attempt takes up to a second.
inline constexpr double kLongestSearchPauseS = 0.75;

// Begins a search from `begin` to `give_up`; `known` is the camera that was lost.
std::shared_ptr<DriverSearch> SearchDriver(const Reconnection& how, const DeviceInfo& known,
                                           std::chrono::steady_clock::time_point begin,
                                           std::chrono::steady_clock::time_point give_up);

// Makes one attempt, elsewhere for an odd number `attempt`, and starts the driver. Throws Error if the camera
// is not found; if another one is, `refused` says so.
std::unique_ptr<Device> FindAgain(const Reconnection& how, const DeviceInfo& known, int attempt,
                                  std::string* refused);

}  // namespace ulf::acquisition
