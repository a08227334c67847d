// Searches for the driver of a lost camera in a separate thread, alternately where the camera was and
// wherever it is now, until the same camera streams again or the time is over.
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <string>

#include "acquisition/device/device.h"
#include "core/base/mutex.h"

namespace ulf::acquisition {

// Opens a driver again, not started; `known` is the lost one's Info(). Throws Error. Runs in another thread.
using ReopenDriver = std::function<std::unique_ptr<Device>(const DeviceInfo& known)>;

struct Reconnection {
  ReopenDriver where_it_was;
  ReopenDriver elsewhere;  // wherever it is now; none: only where it was
  // The camera is searched for this time; 0: not at all. Guessed: time to change a cable or a battery.
  double patience_s = 300;
};

// The state shared by the thread that searches and the device that waits, which may give up first.
struct DriverSearch {
  Mutex mutex;
  ConditionVariable changed;
  bool stop ULF_GUARDED_BY(mutex) = false;              // the device no longer waits
  bool over ULF_GUARDED_BY(mutex) = false;              // the patience is over
  std::unique_ptr<Device> found ULF_GUARDED_BY(mutex);  // the same camera, started
  std::string problem ULF_GUARDED_BY(mutex);            // of the last attempt
  std::string refused ULF_GUARDED_BY(mutex);  // why another camera was refused; empty: none was found
};

// The longest pause between two attempts. Guessed: an attempt takes up to a second.
inline constexpr double kLongestSearchPauseS = 0.75;

// Searches from `begin` to `give_up`; `known` is the camera that was lost.
std::shared_ptr<DriverSearch> SearchDriver(const Reconnection& how, const DeviceInfo& known,
                                           std::chrono::steady_clock::time_point begin,
                                           std::chrono::steady_clock::time_point give_up);

// Makes one attempt and starts the driver. Throws Error without the camera; fills `refused` if another is
// there.
std::unique_ptr<Device> FindAgain(const Reconnection& how, const DeviceInfo& known, int attempt,
                                  std::string* refused);

}  // namespace ulf::acquisition
