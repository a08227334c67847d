// Frame rate, dropped frames and free disk space for the status line. The device and the disk are asked at
// most once a second.
#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <optional>

#include "acquisition/device/device.h"

namespace ulf::coverage {

class CaptureMeters {
 public:
  void FrameAt(double device_time_s);
  std::optional<double> FramesPerS() const;  // over the last second; none before two frames
  std::uint64_t Dropped(const acquisition::Device& device);
  std::optional<std::uint64_t> DiskLeftBytes(const std::filesystem::path& dir);

 private:
  using Clock = std::chrono::steady_clock;
  std::deque<double> times_s_;
  std::optional<Clock::time_point> asked_device_, asked_disk_;
  std::uint64_t dropped_ = 0;
  std::optional<std::uint64_t> disk_left_bytes_;
};

}  // namespace ulf::coverage
