// Counts the statistics of a driver's stream: frames that arrived and did not, and the camera's clock
// relative to this computer's. All functions may be called from any thread.
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

class StreamStatistics {
 public:
  // Call it when a stream begins: all counts restart.
  void Begin();
  // Call it when the stream ends: its seconds count no further.
  void End();

  // Notes a frame's number, complete or not, in the order of arrival.
  void Arrived(std::uint64_t id);
  void ArrivedWithoutId();
  // Call it when the camera restarts its numbers.
  void NumbersRestart();
  void Incomplete();
  // Counts a frame that was discarded because automatics were on when it was exposed.
  void WhileSettling();
  void Dropped();
  // Notes a complete frame's times by both clocks; more than `period_s` apart it is late (0: never).
  void Timed(double device_time_s, double host_time_s, double period_s);
  // Counts a frame that the reader got.
  void Delivered(const Frame& frame);

  // Returns the statistics without the figures of the transport.
  DeviceStatistics Now() const;
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

// Starts a thread that reads frames: it runs `read`, and `lost` with the reason where that throws.
std::thread ReadingThread(std::function<void()> read, std::function<void(const std::string&)> lost);

}  // namespace ulf::acquisition
