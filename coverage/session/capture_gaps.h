// Notes gaps: periods in which a capture could not record, for lack of a pose, a device or room on the disk,
// or because it was paused by request. Each is written to the journal when it ends, so that review can show
// it; of lost tracking and a slow disk only gaps of half a second or more count. Times are the device's.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "coverage/session/record/view_spool.h"

namespace ulf::coverage {

class CaptureGaps {
 public:
  CaptureGaps(ViewSpool& spool, std::function<void(const std::string&)> say)
      : spool_(spool), say_(std::move(say)) {}

  // Call Tracking(), FrameCame() and Disk() for every frame. No gap of tracking begins before the first pose.
  void Tracking(bool tracked, double now_s);
  // The gap lasts from `since_s`, the last frame before the fault, to the next frame.
  void DeviceFaulted(double since_s, const std::string& reason);
  // A live device that was silent for half a second and ten periods counts as faulted.
  void FrameCame(double device_time_s, bool device_is_live, double frame_period_s);
  void Disk(const std::optional<SpoolPause>& pause, double now_s);
  void Recording(bool on, double now_s);  // call it when recording is paused or resumed by request
  // Ends the gaps that are still open, but for lost tracking. `now_s`: none: no frame has come.
  void End(std::optional<double> now_s);

  // Returns why recording is paused for the disk, in words; empty if it is not.
  std::string DiskReason() const { return disk_ ? disk_->reason : std::string(); }
  std::uint64_t pauses() const { return pauses_; }  // for the disk
  double paused_s() const { return paused_s_; }

 private:
  struct Open {
    double from_s = 0;
    std::string reason;
    std::chrono::steady_clock::time_point began = std::chrono::steady_clock::now();
    bool said = false;
  };
  void Close(std::optional<Open>& gap, double to_s);
  void EndDisk(double now_s, bool ended);

  ViewSpool& spool_;
  std::function<void(const std::string&)> say_;
  std::optional<Open> tracking_, device_, disk_, by_request_;
  std::optional<double> last_frame_s_;
  std::chrono::steady_clock::time_point last_frame_at_ = std::chrono::steady_clock::now();
  bool tracked_before_ = false;
  std::uint64_t pauses_ = 0;
  double paused_s_ = 0;
};

}  // namespace ulf::coverage
