#include "coverage/session/capture_gaps.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/base/host_time.h"
#include "coverage/bound/view_decision.h"

namespace ulf::coverage {
namespace {

// Guessed.
// Shorter ones (the disk catches up, one lost frame) are not reported or journaled.
constexpr double kGapShortest_s = 0.5;
// Fewer missed frames of a camera that streams on are dropped frames, no gap.
constexpr double kGapMissedFrames = 10;

}  // namespace

void CaptureGaps::Close(std::optional<Open>& gap, double to_s) {
  if (gap) spool_.NoteGap(gap->from_s, to_s, gap->reason);
  gap.reset();
}

// No gap begins before the first pose.
void CaptureGaps::Tracking(bool tracked, double now_s) {
  tracked_before_ |= tracked;
  if (!tracked && tracked_before_ && !tracking_) tracking_ = Open{now_s, Name(Reason::kTracking)};
  if (!tracked || !tracking_) return;
  if (now_s - tracking_->from_s < kGapShortest_s) tracking_.reset();
  Close(tracking_, now_s);
}

void CaptureGaps::DeviceFaulted(double since_s, const std::string& reason) {
  if (!device_) device_ = Open{since_s, "device: " + reason, last_frame_at_};
}

// A camera may stop for seconds and continue by itself: its driver reports no fault, but it is a gap.
void CaptureGaps::FrameCame(double device_time_s, bool device_is_live, double frame_period_s) {
  if (last_frame_s_ && device_is_live && frame_period_s > 0 &&
      device_time_s - *last_frame_s_ > std::max(kGapShortest_s, kGapMissedFrames * frame_period_s))
    DeviceFaulted(*last_frame_s_, "no frames");
  Close(device_, device_time_s);
  last_frame_s_ = device_time_s;
  last_frame_at_ = std::chrono::steady_clock::now();
}

void CaptureGaps::Disk(const std::optional<SpoolPause>& pause, double now_s) {
  if (!pause) return EndDisk(now_s, false);
  if (!disk_) disk_ = Open{now_s, pause->words};
  if (disk_->said || now_s - disk_->from_s < kGapShortest_s) return;
  disk_->said = true;
  say_("recording paused, tracking goes on: " + pause->words);
}

void CaptureGaps::EndDisk(double now_s, bool ended) {
  if (!disk_) return;
  const double length_s = now_s - disk_->from_s;
  if (length_s >= kGapShortest_s) {
    ++pauses_;
    paused_s_ += length_s;
    spool_.NoteGap(disk_->from_s, now_s, "recording paused: " + disk_->reason);
    if (disk_->said)
      say_(ended ? fmt::format("recording was still paused when the capture ended, after {:.1f} s", length_s)
                 : fmt::format("recording goes on after {:.1f} s", length_s));
  }
  disk_.reset();
}

void CaptureGaps::Recording(bool on, double now_s) {
  if (on) return Close(by_request_, now_s);
  if (!by_request_) by_request_ = Open{now_s, "recording paused: as asked"};
}

void CaptureGaps::End(std::optional<double> now_s) {
  // Without frames only this machine's clock measures how long the device has been gone.
  if (device_) Close(device_, device_->from_s + SecondsSince(device_->began));
  if (!now_s) return;
  Close(by_request_, *now_s);
  EndDisk(*now_s, true);
}

}  // namespace ulf::coverage
