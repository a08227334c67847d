#include "acquisition/device/background_closer.h"

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <thread>

#include "core/base/signal_stack.h"

namespace ulf::acquisition {
namespace {

struct Work {
  std::mutex mutex;
  std::condition_variable done;
  int under_way = 0;
};

// Shared with the threads: one that outlives the wait at the end still finds its counter.
std::shared_ptr<Work> SharedWork() {
  static const auto work = std::make_shared<Work>();
  return work;
}

struct WaitAtTheEnd {
  std::shared_ptr<Work> work = SharedWork();
  ~WaitAtTheEnd() {
    std::unique_lock lock(work->mutex);
    work->done.wait_for(lock, std::chrono::seconds(10), [&] { return work->under_way == 0; });
  }
};

}  // namespace

BackgroundCloser& BackgroundCloser::Instance() {
  static BackgroundCloser background_closer;
  static WaitAtTheEnd wait;
  return background_closer;
}

void BackgroundCloser::CloseInBackground(std::function<void()> work) {
  const auto shared = SharedWork();
  {
    const std::lock_guard lock(shared->mutex);
    ++shared->under_way;
  }
  std::thread([shared, work = std::move(work)]() mutable {
    HaveSignalStack();
    work();
    work = nullptr;  // what it holds goes before it counts as done
    const std::lock_guard lock(shared->mutex);
    --shared->under_way;
    shared->done.notify_all();
  }).detach();
}

}  // namespace ulf::acquisition
