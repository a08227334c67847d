#include "tests/support/slow_disk.h"

#include <signal.h>
#include <sys/stat.h>
#include <sys/types.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <condition_variable>
#include <mutex>
#include <optional>

#include "tests/support/test_run.h"

namespace ulf::test {
namespace {

using Clock = std::chrono::steady_clock;
constexpr int kSlowdown = kPatience;
constexpr std::chrono::seconds kGiveUpAfter(20 * kSlowdown);

struct Disk {
  std::mutex mutex;
  std::condition_variable changed;
  std::optional<SlowDisk::Speed> speed;  // none: as fast as it is
  Clock::time_point busy_until;
  int waiting = 0;
  bool gave_up = false;
};

Disk& TheDisk() {
  static Disk disk;
  return disk;
}

std::atomic<int> refuses_with{0};
std::atomic<int> calls_left{0};  // before death; 0: immortal

void CountCall() {
  if (calls_left > 0 && --calls_left == 0) kill(getpid(), SIGKILL);
}

bool IsOnDisk(int descriptor) {
  struct stat file {};
  return fstat(descriptor, &file) == 0 && (S_ISREG(file.st_mode) || S_ISDIR(file.st_mode));
}

void TakeTime(int descriptor, std::size_t bytes, bool a_wait) {
  Disk& disk = TheDisk();
  std::unique_lock lock(disk.mutex);
  if (!disk.speed || !IsOnDisk(descriptor)) return;
  const std::chrono::duration<double> writing(static_cast<double>(bytes) / disk.speed->bytes_per_s);
  const Clock::time_point until = std::max(disk.busy_until, Clock::now()) +
                                  std::chrono::duration_cast<Clock::duration>(writing) +
                                  (a_wait ? kSlowdown * disk.speed->a_wait : std::chrono::milliseconds(0));
  const Clock::time_point longest = Clock::now() + kGiveUpAfter;
  disk.busy_until = until;
  ++disk.waiting;
  disk.changed.wait_until(lock, std::min(until, longest), [&] { return !disk.speed; });
  --disk.waiting;
  if (!disk.speed || until <= longest) return;
  disk.gave_up = true;
  disk.speed.reset();
  disk.changed.notify_all();
}

}  // namespace

SlowDisk::SlowDisk(const Speed& speed) {
  const std::lock_guard lock(TheDisk().mutex);
  TheDisk().speed = speed;
  TheDisk().busy_until = Clock::now();
  TheDisk().gave_up = false;
}

SlowDisk::~SlowDisk() {
  {
    const std::lock_guard lock(TheDisk().mutex);
    TheDisk().speed.reset();
  }
  TheDisk().changed.notify_all();
}

RefusingDisk::RefusingDisk(int error) { refuses_with = error; }
RefusingDisk::~RefusingDisk() { refuses_with = 0; }

void DieBeforeDiskCall(int call) { calls_left = call; }
int DiskCallsLeft() { return calls_left; }

HangingDisk::HangingDisk() : disk_({10 * kGiveUpAfter, 1}) {}
HangingDisk::~HangingDisk() = default;

bool HangingDisk::SomebodyWaits() const {
  const std::lock_guard lock(TheDisk().mutex);
  return TheDisk().waiting > 0;
}

bool HangingDisk::GaveUp() const {
  const std::lock_guard lock(TheDisk().mutex);
  return TheDisk().gave_up;
}

}  // namespace ulf::test

// The linker's names for what it wraps.
// NOLINTBEGIN(bugprone-reserved-identifier)
extern "C" {
ssize_t __real_write(int descriptor, const void* bytes, size_t size);
int __real_fsync(int descriptor);
int __real_ftruncate(int descriptor, off_t size);
int __real_rename(const char* from, const char* to);
int __real_renameat2(int from_folder, const char* from, int to_folder, const char* to, unsigned flags);
int __real_link(const char* from, const char* to);
int __real_unlink(const char* path);

ssize_t __wrap_write(int descriptor, const void* bytes, size_t size) {
  const bool on_disk = ulf::test::IsOnDisk(descriptor);
  if (on_disk) ulf::test::CountCall();
  if (on_disk && ulf::test::refuses_with != 0) return errno = ulf::test::refuses_with, -1;
  ulf::test::TakeTime(descriptor, size, false);
  return __real_write(descriptor, bytes, size);
}

int __wrap_fsync(int descriptor) {
  const bool on_disk = ulf::test::IsOnDisk(descriptor);
  if (on_disk) ulf::test::CountCall();
  if (on_disk && ulf::test::refuses_with != 0) return errno = ulf::test::refuses_with, -1;
  ulf::test::TakeTime(descriptor, 0, true);
  return __real_fsync(descriptor);
}

int __wrap_ftruncate(int descriptor, off_t size) {
  ulf::test::CountCall();
  return __real_ftruncate(descriptor, size);
}

int __wrap_rename(const char* from, const char* to) {
  ulf::test::CountCall();
  return __real_rename(from, to);
}

int __wrap_renameat2(int from_folder, const char* from, int to_folder, const char* to, unsigned flags) {
  ulf::test::CountCall();
  return __real_renameat2(from_folder, from, to_folder, to, flags);
}

int __wrap_link(const char* from, const char* to) {
  ulf::test::CountCall();
  return __real_link(from, to);
}

int __wrap_unlink(const char* path) {
  ulf::test::CountCall();
  return __real_unlink(path);
}
}
// NOLINTEND(bugprone-reserved-identifier)
