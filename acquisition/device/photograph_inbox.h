// Queues frames between a camera's thread and the reader: the newest live frames (older ones are dropped and
// counted) and every photograph, photographs first. A tethered camera's frames are still encoded; the reader
// decodes them, so that a dropped frame costs no decoding.
#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <optional>

#include "core/base/mutex.h"
#include "core/frames/frame.h"

namespace ulf::acquisition {

class PhotographInbox {
 public:
  explicit PhotographInbox(std::size_t live_capacity) : live_capacity_(live_capacity) {}

  void Push(Frame frame) {
    {
      const MutexLock lock(mutex_);
      std::deque<Frame>& frames = frame.kind == FrameKind::kStill ? stills_ : live_;
      if (&frames == &live_ && live_.size() == live_capacity_) {
        live_.pop_front();
        ++dropped_;
      }
      frames.push_back(std::move(frame));
    }
    arrived_.notify_one();
  }
  // No more frames will be pushed; Pop() still returns those that wait.
  void Close() {
    {
      const MutexLock lock(mutex_);
      closed_ = true;
    }
    arrived_.notify_all();
  }

  std::optional<Frame> Pop(std::chrono::milliseconds timeout) {
    MutexLock lock(mutex_);
    arrived_.wait_for(lock, timeout, [this]() ULF_REQUIRES(mutex_) {
      return closed_ || !stills_.empty() || !live_.empty();
    });
    std::deque<Frame>& from = stills_.empty() ? live_ : stills_;
    if (from.empty()) return std::nullopt;
    std::optional<Frame> frame(std::move(from.front()));
    from.pop_front();
    return frame;
  }
  bool IsEmpty() const {
    const MutexLock lock(mutex_);
    return stills_.empty() && live_.empty();
  }
  std::uint64_t Dropped() const {
    const MutexLock lock(mutex_);
    return dropped_;
  }

 private:
  const std::size_t live_capacity_;
  mutable Mutex mutex_;
  ConditionVariable arrived_;
  std::deque<Frame> stills_ ULF_GUARDED_BY(mutex_), live_ ULF_GUARDED_BY(mutex_);
  std::uint64_t dropped_ ULF_GUARDED_BY(mutex_) = 0;
  bool closed_ ULF_GUARDED_BY(mutex_) = false;
};

}  // namespace ulf::acquisition
