#include "acquisition/device/event_log.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <utility>

#include "core/base/host_time.h"

namespace ulf::acquisition {

void EventLog::Say(DeviceEventKind kind, std::string text, double silence_s) {
  if (!name_.empty()) spdlog::debug("{}: {}", name_, text);
  Pass({kind, EpochSeconds(), std::move(text), silence_s});
}

void EventLog::Pass(DeviceEvent event) {
  const MutexLock lock(mutex_);
  events_.push_back(std::move(event));
}

std::vector<DeviceEvent> EventLog::Take() {
  const MutexLock lock(mutex_);
  return std::exchange(events_, {});
}

void StallReport::FrameCame() {
  const double silence_s = SecondsSince(last_frame_);
  if (std::exchange(stalled_, false))
    log_.Say(DeviceEventKind::kNotice, fmt::format("frames come again after {:.1f} s", silence_s), silence_s);
  last_frame_ = std::chrono::steady_clock::now();
}

bool StallReport::NoFrame(double silence_s, double stall_s) {
  if (silence_s <= stall_s || std::exchange(stalled_, true)) return false;
  log_.Say(DeviceEventKind::kStalled, fmt::format("no frame for {:.1f} s", silence_s), silence_s);
  return true;
}

}  // namespace ulf::acquisition
