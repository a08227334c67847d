// Defines a bounded queue between threads. When it is full, Push() drops the oldest item and counts it,
// because a live camera does not wait. Photographs are never dropped, do not count towards the capacity, and
// are taken before live frames. Any number of threads may push and pop. After Close() Push() fails.
//
// A tethered camera's frames are queued encoded; the reader decodes them, so that dropped ones cost nothing.
#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <optional>
#include <utility>

#include "core/base/error.h"
#include "core/base/mutex.h"
#include "core/frames/frame.h"

namespace ulf::acquisition {

// Returns whether the queue must keep the item.
template <typename T>
bool MustBeKept(const T& /*item*/) {
  return false;
}
inline bool MustBeKept(const Frame& frame) { return frame.kind == FrameKind::kStill; }

template <typename T>
class BoundedQueue {
 public:
  explicit BoundedQueue(std::size_t capacity) : capacity_(capacity) {
    if (capacity == 0) throw Error("a queue needs room for at least one item");
  }
  BoundedQueue(const BoundedQueue&) = delete;
  BoundedQueue& operator=(const BoundedQueue&) = delete;

  // Returns false when the queue is closed; the item then does not count as dropped. `dropped` receives the
  // item that was dropped, if any.
  bool Push(T item, std::optional<T>* dropped = nullptr) {
    MutexLock lock(mutex_);
    if (closed_) return false;
    std::deque<T>& items = MustBeKept(item) ? kept_ : items_;
    if (&items == &items_ && items_.size() == capacity_) {
      if (dropped) *dropped = std::move(items_.front());
      items_.pop_front();
      ++dropped_;
    }
    items.push_back(std::move(item));
    lock.unlock();
    arrived_.notify_one();
    return true;
  }

  // Returns the oldest item; none if none comes within the timeout, or the queue is closed and empty.
  std::optional<T> Pop(std::chrono::milliseconds timeout) {
    MutexLock lock(mutex_);
    arrived_.wait_for(lock, timeout,
                      [this]() ULF_REQUIRES(mutex_) { return closed_ || !kept_.empty() || !items_.empty(); });
    std::deque<T>& from = kept_.empty() ? items_ : kept_;
    if (from.empty()) return std::nullopt;
    std::optional<T> item(std::move(from.front()));
    from.pop_front();
    return item;
  }

  void Close() {
    {
      const MutexLock lock(mutex_);
      closed_ = true;
    }
    arrived_.notify_all();
  }

  bool IsClosed() const {
    const MutexLock lock(mutex_);
    return closed_;
  }
  std::size_t Size() const {
    const MutexLock lock(mutex_);
    return kept_.size() + items_.size();
  }
  // Items that were dropped for newer ones.
  std::uint64_t Dropped() const {
    const MutexLock lock(mutex_);
    return dropped_;
  }

 private:
  const std::size_t capacity_;
  mutable Mutex mutex_;
  ConditionVariable arrived_;
  std::deque<T> kept_ ULF_GUARDED_BY(mutex_), items_ ULF_GUARDED_BY(mutex_);
  std::uint64_t dropped_ ULF_GUARDED_BY(mutex_) = 0;
  bool closed_ ULF_GUARDED_BY(mutex_) = false;
};

using FrameQueue = BoundedQueue<Frame>;

}  // namespace ulf::acquisition
