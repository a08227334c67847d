#include "acquisition/device/background_closer.h"

#include <chrono>
#include <thread>

#include "core/base/mutex.h"
#include "core/base/signal_stack.h"

namespace ulf::acquisition {
namespace {

struct Work {
  Mutex mutex;
  ConditionVariable done;
  int under_way ULF_GUARDED_BY(mutex) = 0;
};

// Shared with the threads: one that outlives the wait at the end still finds its counter.
std::shared_ptr<Work> SharedWork() {
  static const auto work = std::make_shared<Work>();
  return work;
}

struct WaitAtTheEnd {
  std::shared_ptr<Work> work = SharedWork();
  ~WaitAtTheEnd() {
    MutexLock lock(work->mutex);
    work->done.wait_for(lock, std::chrono::seconds(10),
                        [this]() ULF_REQUIRES(work->mutex) { return work->under_way == 0; });
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
    const MutexLock lock(shared->mutex);
    ++shared->under_way;
  }
  std::thread([shared, work = std::move(work)]() mutable {
    HaveSignalStack();
    work();
    work = nullptr;  // what it holds goes before it counts as done
    const MutexLock lock(shared->mutex);
    --shared->under_way;
    shared->done.notify_all();
  }).detach();
}

}  // namespace ulf::acquisition
