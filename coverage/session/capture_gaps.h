// Time in which a capture recorded nothing that it should have, each written to the journal as a gap when it
// ends: no pose, no device, a disk that is behind or full, a pause that was asked for. Times are the
// device's.
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

  void Tracking(bool tracked, double now_s);
  // From the last frame before the fault to the next frame.
  void DeviceFaulted(double since_s, const std::string& reason);
  void FrameCame(double device_time_s, bool device_is_live, double frame_period_s);
  void Disk(const std::optional<SpoolPause>& pause, double now_s);
  void Recording(bool on, double now_s);
  // Closes what is still open.
  void End(std::optional<double> now_s);

  // Why the disk takes nothing, for people; empty: it does.
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
  std::optional<Open> tracking_, device_, disk_, asked_;
  std::optional<double> last_frame_s_;
  bool tracked_before_ = false;
  std::uint64_t pauses_ = 0;
  double paused_s_ = 0;
};

}  // namespace ulf::coverage
