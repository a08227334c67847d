#include "coverage/session/record/capture_recorder.h"

#include <chrono>
#include <utility>

#include "core/base/host_time.h"

namespace ulf::coverage {

CaptureRecorder::CaptureRecorder(acquisition::Device& device, tracking::PoseSource& poses,
                                 const CaptureLens& lens, CaptureRecord& record, ExposureMatch light,
                                 const Options& options, const std::function<void(const std::string&)>& say)
    : device_(device),
      poses_(poses),
      lens_(lens),
      record_(record),
      options_(options),
      light_(std::move(light)) {
  if (options.without_subject) walk_.emplace(*options.without_subject);
  if (options.still_camera)
    stills_.emplace(device, *options.still_camera, poses, options.limits, options.coverage_width_px);
  if (options.bracket)
    bracket_.emplace(device, poses, record.spool(), *options.bracket,
                     BracketCapture::Options{.deterministic = options.deterministic}, say);
}

bool CaptureRecorder::ExposureIsSettled(const Frame& frame, const tracking::Track& track) {
  if (!record_.map() || !track.cam_from_world) return true;
  return exposure_.Settled(frame, lens_.live(), *track.cam_from_world, record_.map()->subject(),
                           device_.Held().exposure);
}

double CaptureRecorder::DistanceToSubject(const tracking::Track& track) const {
  return (*track.cam_from_world * record_.map()->subject().center_in_world).norm();
}

bool CaptureRecorder::Record(const Frame& frame, const tracking::Track& track, const Decision& decision,
                             double distance) {
  Frame kept = frame;  // shares the pixels: no device writes into them again
  if (options_.deterministic) kept.host_time_s = kept.device_time_s;
  const bool light_is_matched = kept.exposure_s <= 0 && device_.Held().exposure != true;
  if (light_is_matched)
    kept.gain = light_.GainOf(kept.image, lens_.recorded(), *track.cam_from_world, distance, record_.views());
  newest_id_ = record_.Add(kept, track, decision.bound_px, poses_);
  if (!newest_id_) return false;
  if (light_is_matched) light_.Keep(*newest_id_);
  if (bracket_) bracket_->Begin(*newest_id_, kept, track);
  newest_view_ = std::make_shared<RecordedFrame>(
      RecordedFrame{*newest_id_, std::move(kept), lens_.recorded(), *track.cam_from_world});
  return true;
}

Reason CaptureRecorder::DiskReason() const {
  const auto pause = record_.spool().Pause();
  return pause && pause->disk_is_full ? Reason::kDisk : Reason::kSpool;
}

void CaptureRecorder::RecordHeld() {
  if (const auto held = walk_ ? walk_->TakeHeld() : std::nullopt) RecordAndCount(*held);
}

// The map, or the lens, may have been corrected since the frame came.
void CaptureRecorder::RecordAndCount(const HeldFrame& held) {
  tracking::Track track = held.track;
  if (track.anchor) track.cam_from_world = poses_.PoseOf(*track.anchor);
  const bool recorded = Record(held.frame, track, {Reason::kRecorded, {}}, held.depth);
  Count(recorded ? Reason::kRecorded : DiskReason());
}

void CaptureRecorder::SetRecording(bool on) {
  if (!on) RecordHeld();
  recording_ = on;
}

// A held frame is counted when it is recorded or dropped.
Decision CaptureRecorder::DecideOnWalk(const Frame& frame, const tracking::Track& track,
                                       double frame_period_s) {
  const auto start = std::chrono::steady_clock::now();
  tracked_in_a_row_ = track.state == tracking::TrackState::kTracking ? tracked_in_a_row_ + 1 : 0;
  PosedPhotographs::Step step;
  if (record_.views().empty() && tracked_in_a_row_ < options_.stable_frames) {
    // The tracker may still discard its first map.
    if (walk_->TakeHeld()) Count(Reason::kTracking);
  } else {
    const FrameToDecide input{.frame = frame,
                              .track = track,
                              .camera = lens_.live(),
                              .frame_period_s = frame_period_s,
                              .coverage_width_px = options_.coverage_width_px};
    if (recording_)
      step = walk_->After(input, poses_.VisiblePoints(), record_.views(), options_.limits);
    else
      step.decision = walk_->Judge(input, poses_.VisiblePoints(), record_.views(), options_.limits);
  }
  ms_decide_.push_back(1000 * SecondsSince(start));
  if (step.record) RecordAndCount(*step.record);
  if (step.replaced) Count(Reason::kCovered);
  if (step.decision.reason == Reason::kRecorded && !recording_) step.decision.reason = Reason::kPaused;
  if (step.decision.reason != Reason::kRecorded) Count(step.decision.reason);
  return step.decision;
}

Decision CaptureRecorder::DecideOnSubject(const Frame& frame, const tracking::Track& track,
                                          double frame_period_s) {
  const auto start = std::chrono::steady_clock::now();
  const bool exposure_settled = ExposureIsSettled(frame, track);
  const FrameToDecide input{.frame = frame,
                            .track = track,
                            .camera = lens_.live(),
                            .frame_period_s = frame_period_s,
                            .coverage_width_px = options_.coverage_width_px,
                            .exposure_settled = exposure_settled};
  const std::shared_ptr<const CoverageMap> map = record_.map();
  Decision decision = Decide(input, map.get(), options_.limits);
  ms_decide_.push_back(1000 * SecondsSince(start));
  if (ShowsTheSubject(decision.reason)) {
    const std::optional<MeasuredFrame> measured = record_.Measure(frame, lens_.live(), track);
    if (measured) ms_measure_.push_back(measured->processor_ms);
    if (record_.map() != map) decision = Decide(input, record_.map().get(), options_.limits);
  }
  if (stills_) stills_->Follow(frame, track);
  if (decision.reason == Reason::kRecorded) {
    if (!recording_) {
      decision.reason = Reason::kPaused;
    } else if (stills_) {
      decision.reason = record_.spool().Pause() ? DiskReason() : Reason::kStill;
      if (decision.reason == Reason::kStill) stills_->Ask();
    } else if (!Record(frame, track, decision, DistanceToSubject(track))) {
      decision.reason = DiskReason();
    }
  }
  Count(decision.reason);
  return decision;
}

// What the tracker takes as a keyframe shows something that those before did not.
bool CaptureRecorder::IsWorthKeepingApart(const tracking::Track& track) const {
  return options_.keep_apart && recording_ && track.state == tracking::TrackState::kApart && track.keyframe &&
         track.sharpness >= options_.limits.min_sharpness && !record_.spool().Pause();
}

Decision CaptureRecorder::Take(const Frame& frame, const tracking::Track& track, double frame_period_s) {
  newest_id_.reset();
  zoom_moved_ = track.focal_ratio.has_value();
  if (bracket_ && bracket_->Take(frame, track)) {
    if (stills_) stills_->Follow(frame, track);
    Count(Reason::kBracket);
    return {Reason::kBracket, {}};
  }
  if (IsWorthKeepingApart(track)) {
    Frame kept = frame;
    if (options_.deterministic) kept.host_time_s = kept.device_time_s;
    record_.spool().KeepUnposed(kept);
    ++kept_apart_;
  }
  return walk_ ? DecideOnWalk(frame, track, frame_period_s) : DecideOnSubject(frame, track, frame_period_s);
}

void CaptureRecorder::TakeStill(const Frame& still) {
  if (still.asked_stops) {
    const auto track = stills_ ? stills_->Find(still) : std::nullopt;
    if (!bracket_ || !bracket_->TakeStill(still, track)) record_.spool().KeepUnposed(still);
    return;
  }
  const StillVerdict verdict = stills_ ? stills_->Judge(still, record_.map().get()) : StillVerdict{};
  if (verdict.decision.reason == Reason::kRecorded)
    Record(still, *verdict.track, verdict.decision, DistanceToSubject(*verdict.track));
  else
    record_.spool().KeepUnposed(still, zoom_moved_ ? "it was taken with the zoom moved" : "");
}

}  // namespace ulf::coverage
