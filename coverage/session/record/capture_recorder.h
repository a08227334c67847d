// Decides for every tracked frame whether it becomes a view, records those that do, and counts the reasons of
// the others. First it measures the frame (light, error), then decides without changing anything, then
// records. With a still camera it requests photographs instead (still_capture.h); without a subject it
// decides by parallax (posed_photographs.h). RunningCapture calls it in the capture's thread.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/device/device.h"
#include "core/geometry/camera_model.h"
#include "coverage/bound/capture_presets.h"
#include "coverage/bound/view_decision.h"
#include "coverage/session/record/bracket_capture.h"
#include "coverage/session/record/capture_lens.h"
#include "coverage/session/record/capture_options.h"
#include "coverage/session/record/capture_record.h"
#include "coverage/session/record/exposure.h"
#include "coverage/session/record/posed_photographs.h"
#include "coverage/session/record/still_capture.h"
#include "tracking/tracker/pose_source.h"

namespace ulf::coverage {

class CaptureRecorder {
 public:
  using ReasonCounts = std::array<std::uint64_t, kReasons.size()>;  // by Reason

  // What is passed by reference outlives it. `light` knows the views of an earlier session.
  CaptureRecorder(acquisition::Device& device, tracking::PoseSource& poses, const CaptureLens& lens,
                  CaptureRecord& record, ExposureMatch light, const CaptureOptions& options,
                  const std::function<void(const std::string&)>& say);

  // Call it for each complete live frame, with the track of ForTracking(frame). Records the frame (without a
  // subject, holds it: RecordHeld()), or returns why not. `frame_period_s`: between the device's frames; 0
  // while it is not known.
  Decision Take(const Frame& frame, const tracking::Track& track, double frame_period_s);
  // Returns the frame as the tracker is to see it.
  Frame ForTracking(const Frame& frame) const { return bracket_ ? bracket_->ForTracking(frame) : frame; }
  // Returns whether other exposures of the newest view are still to come.
  bool AwaitsExposures() const { return bracket_ && bracket_->IsRunning(); }
  // Records a photograph, requested or not, or keeps it in unposed/.
  void TakeStill(const Frame& still);
  // Records the frame that waits to be compared with its neighbours (posed_photographs.h), at the end.
  void RecordHeld();
  // Call it at the end, after everything else.
  void FinishBracket() {
    if (bracket_) bracket_->Finish();
  }

  // While recording is off, frames get a decision and do not become views. Turning it off records the frame
  // that waits to be compared with its neighbours.
  void SetRecording(bool on);
  bool IsRecording() const { return recording_; }

  // Returns the newest view recorded since the last Take() began or ForgetNewestId(); none: there is none.
  std::optional<int> newest_id() const { return newest_id_; }
  void ForgetNewestId() { newest_id_.reset(); }
  std::shared_ptr<const RecordedFrame> newest_view() const { return newest_view_; }  // null: none yet
  const ReasonCounts& reasons() const { return reasons_; }
  std::uint64_t kept_apart() const { return kept_apart_; }  // frames (CaptureOptions::keep_apart)
  BracketCounts brackets() const { return bracket_ ? bracket_->counts() : BracketCounts{}; }
  StillCounts stills() const { return stills_ ? stills_->counts() : StillCounts{}; }
  // The milliseconds that each decision took, and the processor time of each measured frame.
  const std::vector<double>& ms_decide() const { return ms_decide_; }
  const std::vector<double>& ms_measure() const { return ms_measure_; }

 private:
  Decision TakeOnWalk(const FrameToDecide& input);
  Decision TakeOnSubject(FrameToDecide input);
  // Measures the light field's error at a frame that shows the whole subject, which may change the coverage
  // map.
  void Measure(const FrameToDecide& input);
  // Records the frame, or asks for a photograph in its place; what came of it.
  Reason RecordOrAsk(const FrameToDecide& input, const Decision& decision);
  void KeepApart(const Frame& frame, const tracking::Track& track);
  Frame AsKept(const Frame& frame) const;
  // `distance`: to the subject, or the median depth of the tracked points.
  bool Record(const Frame& frame, const tracking::Track& track, const Decision& decision, double distance);
  void RecordAndCount(const HeldFrame& held);
  bool ExposureIsSettled(const Frame& frame, const tracking::Track& track);
  double DistanceToSubject(const tracking::Track& track) const;
  Reason DiskReason() const;
  void Count(Reason reason) { ++reasons_[static_cast<std::size_t>(reason)]; }

  acquisition::Device& device_;
  tracking::PoseSource& poses_;
  const CaptureLens& lens_;
  CaptureRecord& record_;
  const CaptureOptions& options_;
  ExposureMatch light_;
  ExposureWatch exposure_;
  std::optional<StillCapture> stills_;
  std::optional<BracketCapture> bracket_;
  std::optional<PosedPhotographs> walk_;
  int tracked_in_a_row_ = 0;
  bool recording_ = true;
  std::optional<int> newest_id_;
  std::shared_ptr<const RecordedFrame> newest_view_;
  ReasonCounts reasons_{};
  std::uint64_t kept_apart_ = 0;
  bool zoom_moved_ = false;  // in the last live frame
  std::vector<double> ms_decide_, ms_measure_;
};

}  // namespace ulf::coverage
