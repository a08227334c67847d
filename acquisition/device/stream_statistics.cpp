#include "acquisition/device/stream_statistics.h"

#include <utility>

#include "core/base/host_time.h"
#include "core/base/stop_signal.h"

namespace ulf::acquisition {

using Clock = std::chrono::steady_clock;

void StreamStatistics::Begin() {
  const MutexLock lock(mutex_);
  counted_ = {};
  ids_ = {};
  clock_ = {};
  while_settling_ = 0;
  running_ = true;
  began_ = Clock::now();
}

void StreamStatistics::End() {
  const MutexLock lock(mutex_);
  if (std::exchange(running_, false)) counted_.seconds = SecondsSince(began_);
}

void StreamStatistics::Arrived(std::uint64_t id) {
  const MutexLock lock(mutex_);
  ids_.Arrived(id);
}

void StreamStatistics::ArrivedWithoutId() {
  const MutexLock lock(mutex_);
  ids_.ArrivedWithoutId();
}

void StreamStatistics::NumbersRestart() {
  const MutexLock lock(mutex_);
  ids_.Restarted();
}

void StreamStatistics::Incomplete() {
  const MutexLock lock(mutex_);
  ++counted_.incomplete;
}

void StreamStatistics::WhileSettling() {
  const MutexLock lock(mutex_);
  ++while_settling_;
}

void StreamStatistics::Dropped() {
  const MutexLock lock(mutex_);
  ++counted_.dropped;
}

void StreamStatistics::Timed(double device_time_s, double host_time_s, double period_s) {
  const MutexLock lock(mutex_);
  clock_.Add(device_time_s, host_time_s);
  if (period_s > 0 && clock_.LatenessS(device_time_s, host_time_s) > period_s) ++counted_.late;
}

void StreamStatistics::Delivered(const Frame& frame) {
  const MutexLock lock(mutex_);
  ++counted_.delivered;
  counted_.bytes += frame.image.pixels.total() * frame.image.pixels.elemSize();
}

DeviceStatistics StreamStatistics::Now() const {
  const MutexLock lock(mutex_);
  DeviceStatistics statistics = counted_;
  statistics.missing = ids_.Missing();
  statistics.out_of_order = ids_.OutOfOrder();
  statistics.clock_offset_s = clock_.OffsetS();
  statistics.clock_jitter_s = clock_.JitterS();
  if (running_) statistics.seconds = SecondsSince(began_);
  return statistics;
}

double StreamStatistics::WhileSettlingCount() const {
  const MutexLock lock(mutex_);
  return static_cast<double>(while_settling_);
}

std::thread ReadingThread(std::function<void()> read, std::function<void(const std::string&)> lost) {
  return std::thread([read = std::move(read), lost = std::move(lost)] {
    InstallSignalStack();
    try {
      read();
    } catch (const std::exception& error) {
      lost(error.what());
    }
  });
}

}  // namespace ulf::acquisition
