// What a device reports between frames, collected until somebody takes it (Device::TakeEvents), and when its
// silence counts as a stall. All functions of EventLog may be called from any thread.
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
  // Every event goes to the program's log, too, at the level of debugging, as "NAME: TEXT". Before other
  // threads begin.
  void LogAs(std::string name) { name_ = std::move(name); }
  // The event's time is now. `silence_s`: DeviceEvent::silence_s.
  void Say(DeviceEventKind kind, std::string text, double silence_s = 0);
  void Notice(std::string text) { Say(DeviceEventKind::kNotice, std::move(text)); }
  // Takes over an event of another log.
  void Pass(DeviceEvent event);
  std::vector<DeviceEvent> Take();

 private:
  std::string name_;  // empty: not logged
  Mutex mutex_;
  std::vector<DeviceEvent> events_ ULF_GUARDED_BY(mutex_);
};

// Reports once that no frame comes for longer than normal, and once that frames come again. For the thread
// that reads the frames of one stream.
class StallReport {
 public:
  explicit StallReport(EventLog& log) : log_(log) {}

  std::chrono::steady_clock::time_point LastFrame() const { return last_frame_; }
  void FrameCame();
  // `silence_s`: without a frame that is due. True when the stall is reported now.
  bool NoFrame(double silence_s, double stall_s);
  // No frame is due: the next silence is a stall of its own.
  void Forget() { stalled_ = false; }

 private:
  EventLog& log_;
  std::chrono::steady_clock::time_point last_frame_ = std::chrono::steady_clock::now();
  bool stalled_ = false;
};

}  // namespace ulf::acquisition
