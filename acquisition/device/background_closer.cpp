#include "acquisition/device/background_closer.h"

#include <chrono>
#include <thread>

#include "core/base/mutex.h"
#include "core/base/stop_signal.h"

namespace ulf::acquisition {
namespace {

struct Work {
  Mutex mutex;
  ConditionVariable done;
  int under_way ULF_GUARDED_BY(mutex) = 0;
};

// Shared with the threads, so that a thread that outlives the wait at exit still has its counter.
std::shared_ptr<Work> SharedWork() {
  static const auto work = std::make_shared<Work>();
  return work;
}

// Guessed: longer than a library's retries last, short enough for a person at a terminal.
constexpr std::chrono::seconds kLongestWait(10);

struct WaitAtExit {
  std::shared_ptr<Work> work = SharedWork();
  ~WaitAtExit() {
    MutexLock lock(work->mutex);
    work->done.wait_for(lock, kLongestWait,
                        [this]() ULF_REQUIRES(work->mutex) { return work->under_way == 0; });
  }
};

}  // namespace

void CloseInBackground(std::function<void()> work) {
  static const WaitAtExit wait;
  const auto shared = SharedWork();
  {
    const MutexLock lock(shared->mutex);
    ++shared->under_way;
  }
  std::thread([shared, work = std::move(work)]() mutable {
    InstallSignalStack();
    work();
    work = nullptr;  // destroys what it holds before it counts as done
    const MutexLock lock(shared->mutex);
    --shared->under_way;
    shared->done.notify_all();
  }).detach();
}

}  // namespace ulf::acquisition
