// Collects a device's events until they are taken (Device::TakeEvents), and reports stalls. All functions of
// EventLog may be called from any thread.
#pragma once

#include <chrono>
#include <string>
#include <utility>
#include <vector>

#include "acquisition/device/device.h"
#include "core/base/mutex.h"

namespace ulf::acquisition {

class EventLog {
 public:
  // Makes Say() also write to the program's debug log, "NAME: TEXT". Call it before other threads begin.
  void LogAs(std::string name) { name_ = std::move(name); }
  // Adds an event with the present time.
  void Say(DeviceEventKind kind, std::string text, double silence_s = 0);
  void Notice(std::string text) { Say(DeviceEventKind::kNotice, std::move(text)); }
  // Adds an event as it is, from another log.
  void Pass(DeviceEvent event);
  // Returns the events since the last call, in their order.
  std::vector<DeviceEvent> Take();

 private:
  std::string name_;  // empty: not logged
  Mutex mutex_;
  std::vector<DeviceEvent> events_ ULF_GUARDED_BY(mutex_);
};

// Reports once that no frame comes for longer than normal, and once that frames come again. It belongs to the
// thread that reads one stream's frames.
class StallReport {
 public:
  explicit StallReport(EventLog& log) : log_(log) {}

  std::chrono::steady_clock::time_point LastFrame() const { return last_frame_; }
  void FrameCame();
  // Reports a stall if no due frame has come for `silence_s` > `stall_s`. Returns whether it reported.
  bool NoFrame(double silence_s, double stall_s);
  // Call it when no frame is due: the next silence is a new stall.
  void EndStall() { stalled_ = false; }

 private:
  EventLog& log_;
  std::chrono::steady_clock::time_point last_frame_ = std::chrono::steady_clock::now();
  bool stalled_ = false;
};

}  // namespace ulf::acquisition
