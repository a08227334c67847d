#include "coverage/session/capture_meters.h"

#include <algorithm>
#include <limits>

#include "core/base/atomic_file.h"

namespace ulf::coverage {
namespace {

bool IsDue(std::optional<std::chrono::steady_clock::time_point>& asked) {
  const auto now = std::chrono::steady_clock::now();
  if (asked && now - *asked < std::chrono::seconds(1)) return false;
  asked = now;
  return true;
}

}  // namespace

void CaptureMeters::FrameAt(double device_time_s) {
  constexpr double kOver_s = 1;
  constexpr double kSlower = 1.1;  // how fast the period follows a camera that gets slower, a frame
  if (!first_time_s_) first_time_s_ = device_time_s;
  if (const double step_s = device_time_s - last_time_s_.value_or(device_time_s); step_s > 0)
    frame_period_s_ = frame_period_s_ > 0 ? std::min(step_s, kSlower * frame_period_s_) : step_s;
  last_time_s_ = device_time_s;
  if (!times_s_.empty() && device_time_s < times_s_.back()) times_s_.clear();  // the clock was reset
  times_s_.push_back(device_time_s);
  while (times_s_.size() > 2 && device_time_s - times_s_.front() > kOver_s) times_s_.pop_front();
}

std::optional<double> CaptureMeters::FramesPerS() const {
  if (times_s_.size() < 2 || !(times_s_.back() > times_s_.front())) return std::nullopt;
  return static_cast<double>(times_s_.size() - 1) / (times_s_.back() - times_s_.front());
}

std::uint64_t CaptureMeters::Dropped(const acquisition::Device& device) {
  if (IsDue(asked_device_)) {
    const acquisition::DeviceStatistics statistics = device.Statistics();
    dropped_ = statistics.dropped + statistics.missing + statistics.incomplete;
  }
  return dropped_;
}

std::optional<std::uint64_t> CaptureMeters::DiskLeftBytes(const std::filesystem::path& dir) {
  if (IsDue(asked_disk_)) {
    disk_left_bytes_ = FreeBytes(dir);
    if (*disk_left_bytes_ == std::numeric_limits<std::uint64_t>::max()) disk_left_bytes_.reset();
  }
  return disk_left_bytes_;
}

const std::vector<acquisition::LinkFact>& CaptureMeters::Link(const acquisition::Device& device) {
  if (!IsDue(asked_link_)) return link_;
  const acquisition::DeviceInfo camera = device.Info();
  const acquisition::DeviceStatistics statistics = device.Statistics();
  link_ = acquisition::DescribeLink(camera, acquisition::LinkPathTo(camera), statistics).facts;
  if (auto lost = acquisition::LostSoFar(camera, statistics)) link_.push_back(std::move(*lost));
  return link_;
}

}  // namespace ulf::coverage
