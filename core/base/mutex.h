// A mutex, its lock and a condition variable that Clang's thread-safety analysis can follow. They are the
// standard library's, by the same names and at the same cost, with the analysis' attributes on them.
//
// A member says which mutex guards it (ULF_GUARDED_BY), a function which one its caller must hold
// (ULF_REQUIRES) or must not hold (ULF_EXCLUDES); a build with the preset "clang" fails where the code does
// otherwise. GCC sees none of it. https://clang.llvm.org/docs/ThreadSafetyAnalysis.html
//
// To the analysis a lambda is a function of its own. If its caller holds the lock, as for the predicate of a
// wait, the lambda says so: [this]() ULF_REQUIRES(mutex_) { return stopped_; }. The analysis follows members
// and static variables, not the local variables of a function.
#pragma once

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <utility>

#if defined(__clang__)
#define ULF_THREAD_SAFETY(...) __attribute__((__VA_ARGS__))
#else
#define ULF_THREAD_SAFETY(...)
#endif

#define ULF_CAPABILITY(name) ULF_THREAD_SAFETY(capability(name))
#define ULF_SCOPED_CAPABILITY ULF_THREAD_SAFETY(scoped_lockable)
#define ULF_GUARDED_BY(...) ULF_THREAD_SAFETY(guarded_by(__VA_ARGS__))
#define ULF_REQUIRES(...) ULF_THREAD_SAFETY(requires_capability(__VA_ARGS__))
#define ULF_EXCLUDES(...) ULF_THREAD_SAFETY(locks_excluded(__VA_ARGS__))
#define ULF_ACQUIRE(...) ULF_THREAD_SAFETY(acquire_capability(__VA_ARGS__))
#define ULF_TRY_ACQUIRE(...) ULF_THREAD_SAFETY(try_acquire_capability(__VA_ARGS__))
#define ULF_RELEASE(...) ULF_THREAD_SAFETY(release_capability(__VA_ARGS__))
#define ULF_NO_THREAD_SAFETY_ANALYSIS ULF_THREAD_SAFETY(no_thread_safety_analysis)

namespace ulf {

class ConditionVariable;

class ULF_CAPABILITY("mutex") Mutex {
 public:
  void lock() ULF_ACQUIRE() { mutex_.lock(); }
  void unlock() ULF_RELEASE() { mutex_.unlock(); }
  bool try_lock() ULF_TRY_ACQUIRE(true) { return mutex_.try_lock(); }

 private:
  friend class MutexLock;
  std::mutex mutex_;
};

// Locks a mutex until the end of its scope; unlock() and lock() may interrupt this.
class ULF_SCOPED_CAPABILITY MutexLock {
 public:
  explicit MutexLock(Mutex& mutex) ULF_ACQUIRE(mutex) : lock_(mutex.mutex_) {}
  ~MutexLock() ULF_RELEASE() {}
  MutexLock(const MutexLock&) = delete;
  MutexLock& operator=(const MutexLock&) = delete;

  void lock() ULF_ACQUIRE() { lock_.lock(); }
  void unlock() ULF_RELEASE() { lock_.unlock(); }

 private:
  friend class ConditionVariable;
  std::unique_lock<std::mutex> lock_;
};

// Every wait() needs the lock held, and holds it again when it returns.
class ConditionVariable {
 public:
  void notify_one() noexcept { condition_.notify_one(); }
  void notify_all() noexcept { condition_.notify_all(); }

  template <typename Predicate>
  void wait(MutexLock& lock, Predicate predicate) {
    condition_.wait(lock.lock_, std::move(predicate));
  }

  // These return the predicate's last value: false if the time ran out first.
  template <typename Rep, typename Period, typename Predicate>
  bool wait_for(MutexLock& lock, const std::chrono::duration<Rep, Period>& time, Predicate predicate) {
    return condition_.wait_for(lock.lock_, time, std::move(predicate));
  }
  template <typename Clock, typename Duration, typename Predicate>
  bool wait_until(MutexLock& lock, const std::chrono::time_point<Clock, Duration>& end, Predicate predicate) {
    return condition_.wait_until(lock.lock_, end, std::move(predicate));
  }

  // Returns after a notification, at the time `end`, or spuriously.
  template <typename Clock, typename Duration>
  void wait_until(MutexLock& lock, const std::chrono::time_point<Clock, Duration>& end) {
    condition_.wait_until(lock.lock_, end);
  }

 private:
  std::condition_variable condition_;
};

}  // namespace ulf
