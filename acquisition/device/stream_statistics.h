// Counts the frames of a driver's stream that arrive or are lost, and compares the camera's clock with this
// computer's. All functions may be called from any thread.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <string>
#include <thread>

#include "acquisition/device/device.h"
#include "acquisition/device/frame_id_counter.h"
#include "core/base/clock_offset.h"
#include "core/base/mutex.h"
#include "core/frames/frame.h"

namespace ulf::acquisition {

// A frame may count several times: an incomplete one by Arrived() and by Incomplete().
class StreamStatistics {
 public:
  // Call it when a stream begins: all counts restart.
  void Begin();
  // Call it when the stream ends: DeviceStatistics::seconds grows no further.
  void End();

  // Counts the arrival of a frame, complete or not, by its frame id. Call it in the order of arrival.
  void Arrived(std::uint64_t id);
  // Counts the arrival of a frame whose id was lost; it fills one gap in the ids.
  void ArrivedWithoutId();
  // Call it when the camera restarts its frame ids.
  void NumbersRestart();
  // Counts a frame that arrived with pixels missing.
  void Incomplete();
  // Counts a complete frame that was discarded because an automatic (exposure, gain, ...) was still on.
  void WhileSettling();
  // Counts a complete frame that was discarded because the reader was too slow.
  void Dropped();
  // Adds a complete frame's times by the device's clock (any origin) and by this computer's (since the
  // epoch). A frame is late if its delay exceeds the least delay by more than `period_s`; with 0 none is.
  void Timed(double device_time_s, double host_time_s, double period_s);
  // Counts a complete frame that Device::Next() returned, and the bytes of its pixels.
  void Delivered(const Frame& frame);

  // Returns the statistics so far; `reconnects` stays 0 and `transport` empty.
  DeviceStatistics Now() const;
  // Returns how often WhileSettling() was called, as a value for TransportFigures.
  double WhileSettlingCount() const;

 private:
  mutable Mutex mutex_;
  DeviceStatistics counted_ ULF_GUARDED_BY(mutex_);
  FrameIdCounter ids_ ULF_GUARDED_BY(mutex_);
  ClockOffset clock_ ULF_GUARDED_BY(mutex_);
  std::uint64_t while_settling_ ULF_GUARDED_BY(mutex_) = 0;
  bool running_ ULF_GUARDED_BY(mutex_) = false;
  std::chrono::steady_clock::time_point began_ ULF_GUARDED_BY(mutex_);
};

// Starts a thread that runs `read`. If `read` throws, the thread calls `lost` with the exception's text;
// `lost` must not throw. The caller joins the thread.
std::thread ReadingThread(std::function<void()> read, std::function<void(const std::string&)> lost);

}  // namespace ulf::acquisition
