// Holds what the drivers of real cameras have in common: a thread that reads frames into a queue, events,
// statistics, and the camera's description. Info(), State() and TakeEvents() may be called from any thread.
//
// A driver whose library calls back copies the pixels and pushes them from the library's thread. Start()
// makes the queue before the first call can come; Stop() ends the calls before it closes the queue. `thread_`
// stays unused.
#pragma once

#include <atomic>
#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "acquisition/device/device.h"
#include "acquisition/device/event_log.h"
#include "acquisition/device/frame_queue.h"
#include "acquisition/device/stream_statistics.h"
#include "core/base/mutex.h"

namespace ulf::acquisition {

class LiveDriver : public Device {
 public:
  DeviceInfo Info() const override {
    const MutexLock lock(mutex_);
    return info_;
  }
  bool IsLive() const override { return true; }
  FrameSource Source() const override { return FrameSource::kSettableCamera; }
  DeviceState State() const override { return state_; }
  std::optional<Frame> Next(std::chrono::milliseconds timeout) override {
    if (!queue_) return std::nullopt;
    std::optional<Frame> frame = queue_->Pop(timeout);
    if (frame && frame->status == FrameStatus::kComplete) statistics_.Delivered(*frame);
    return frame;
  }
  std::vector<DeviceEvent> TakeEvents() override { return events_.Take(); }

 protected:
  // Makes Info() say why the camera is gone.
  void DescribeLoss(const std::string& problem) {
    const MutexLock lock(mutex_);
    info_.available = false;
    info_.problem = problem;
  }

  EventLog events_;
  StreamStatistics statistics_;
  std::unique_ptr<FrameQueue> queue_;  // null before the first Start()
  std::atomic<DeviceState> state_{DeviceState::kConnected};
  std::thread thread_;
  mutable Mutex mutex_;
  DeviceInfo info_ ULF_GUARDED_BY(mutex_);
};

}  // namespace ulf::acquisition
