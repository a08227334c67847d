// Measures the device's time and frame rate, dropped frames and free disk space during a capture. The figures
// of device, link and disk are read at most once a second.
#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <optional>
#include <vector>

#include "acquisition/device/device.h"
#include "acquisition/link/link_facts.h"

namespace ulf::coverage {

class CaptureMeters {
 public:
  void FrameAt(double device_time_s);  // call it for every live frame
  std::optional<double> last_time_s() const { return last_time_s_; }
  double DeviceSeconds() const { return first_time_s_ ? *last_time_s_ - *first_time_s_ : 0; }
  // Returns the shortest recent time between frames, so that a dropped frame does not look like a slow
  // camera; 0: unknown.
  double frame_period_s() const { return frame_period_s_; }
  std::optional<double> FramesPerS() const;                  // over the last second; none before two frames
  std::uint64_t Dropped(const acquisition::Device& device);  // frames dropped, missing or incomplete so far
  std::optional<std::uint64_t> DiskLeftBytes(const std::filesystem::path& dir);  // none: not known
  // Returns what is known of the way to the camera (link_facts.h); empty if it has none.
  const std::vector<acquisition::LinkFact>& Link(const acquisition::Device& device);

 private:
  using Clock = std::chrono::steady_clock;
  std::optional<double> first_time_s_, last_time_s_;
  double frame_period_s_ = 0;
  std::deque<double> times_s_;
  std::optional<Clock::time_point> asked_device_, asked_disk_, asked_link_;
  std::uint64_t dropped_ = 0;
  std::optional<std::uint64_t> disk_left_bytes_;
  std::vector<acquisition::LinkFact> link_;
};

}  // namespace ulf::coverage
