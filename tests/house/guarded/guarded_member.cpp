// Compiled by the test guarded_members: with Clang it must compile with the lock, and without it not at all.
#include "core/base/mutex.h"

namespace ulf {

class Counter {
 public:
  int Count() {
#ifndef WITHOUT_LOCK
    const MutexLock lock(mutex_);
#endif
    return count_;
  }
  void WaitForFirst() {
    MutexLock lock(mutex_);
#ifdef WITHOUT_LOCK
    lock.unlock();
#endif
    Increase();
    changed_.wait(lock, [this]() ULF_REQUIRES(mutex_) { return count_ > 0; });
  }

 private:
  void Increase() ULF_REQUIRES(mutex_) { ++count_; }

  Mutex mutex_;
  ConditionVariable changed_;
  int count_ ULF_GUARDED_BY(mutex_) = 0;
};

}  // namespace ulf

int main() {
  ulf::Counter counter;
  counter.WaitForFirst();
  return counter.Count() - 1;
}
