// A bounded hand-off between threads. What happens when it is full is said when it is made:
//   kDropOldest  a live camera does not wait: the oldest waiting item makes room, and the loss is counted;
//   kBlock       the producer waits for room: nothing is lost (recorded views on their way to disk).
// Any number of threads may push and pop. After Close() pushing fails, and popping drains what is left.
#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <optional>
#include <utility>

#include "core/base/error.h"
#include "core/base/mutex.h"
#include "core/image/frame.h"

namespace ulf::acquisition {

enum class WhenFull { kDropOldest, kBlock };

template <typename T>
class BoundedQueue {
 public:
  BoundedQueue(std::size_t capacity, WhenFull when_full) : capacity_(capacity), when_full_(when_full) {
    if (capacity == 0) throw Error("a queue needs room for at least one item");
  }
  BoundedQueue(const BoundedQueue&) = delete;
  BoundedQueue& operator=(const BoundedQueue&) = delete;

  // False when the queue is closed, also while waiting for room; that is not counted as a drop. What made
  // room is handed back through `dropped` where that is given.
  bool Push(T item, std::optional<T>* dropped = nullptr) {
    MutexLock lock(mutex_);
    if (when_full_ == WhenFull::kBlock)
      room_.wait(lock, [this]() ULF_REQUIRES(mutex_) { return closed_ || items_.size() < capacity_; });
    if (closed_) return false;
    if (items_.size() == capacity_) {
      if (dropped) *dropped = std::move(items_.front());
      items_.pop_front();
      ++dropped_;
    }
    items_.push_back(std::move(item));
    lock.unlock();
    arrived_.notify_one();
    return true;
  }

  // As Push, but never waits: false when there is no room (kBlock) or the queue is closed.
  bool TryPush(T& item) {
    {
      const MutexLock lock(mutex_);
      if (closed_ || items_.size() == capacity_) return false;
      items_.push_back(std::move(item));
    }
    arrived_.notify_one();
    return true;
  }

  // The oldest item, or none within the timeout or when the queue is closed and drained.
  std::optional<T> Pop(std::chrono::milliseconds timeout) {
    MutexLock lock(mutex_);
    arrived_.wait_for(lock, timeout, [this]() ULF_REQUIRES(mutex_) { return closed_ || !items_.empty(); });
    if (items_.empty()) return std::nullopt;
    std::optional<T> item(std::move(items_.front()));
    items_.pop_front();
    lock.unlock();
    room_.notify_one();
    return item;
  }

  void Close() {
    {
      const MutexLock lock(mutex_);
      closed_ = true;
    }
    arrived_.notify_all();
    room_.notify_all();
  }

  bool IsClosed() const {
    const MutexLock lock(mutex_);
    return closed_;
  }
  std::size_t Size() const {
    const MutexLock lock(mutex_);
    return items_.size();
  }
  std::size_t Capacity() const { return capacity_; }
  // Items that made room for newer ones.
  std::uint64_t Dropped() const {
    const MutexLock lock(mutex_);
    return dropped_;
  }

 private:
  const std::size_t capacity_;
  const WhenFull when_full_;
  mutable Mutex mutex_;
  ConditionVariable arrived_;
  ConditionVariable room_;
  std::deque<T> items_ ULF_GUARDED_BY(mutex_);
  std::uint64_t dropped_ ULF_GUARDED_BY(mutex_) = 0;
  bool closed_ ULF_GUARDED_BY(mutex_) = false;
};

using FrameQueue = BoundedQueue<Frame>;

}  // namespace ulf::acquisition
