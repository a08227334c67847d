#include "coverage/session/record/capture_recorder.h"

#include <utility>

#include "core/base/host_time.h"

namespace ulf::coverage {

CaptureRecorder::CaptureRecorder(acquisition::Device& device, tracking::PoseSource& poses,
                                 const CaptureLens& lens, CaptureRecord& record, ExposureMatch light,
                                 const CaptureOptions& options,
                                 const std::function<void(const std::string&)>& say)
    : device_(device),
      poses_(poses),
      lens_(lens),
      record_(record),
      options_(options),
      light_(std::move(light)) {
  if (options.without_subject) walk_.emplace(*options.without_subject);
  if (options.still_camera) stills_.emplace(device, *options.still_camera, poses, options.coverage_width_px);
  if (options.bracket)
    bracket_.emplace(device, poses, record.spool(), *options.bracket, options.deterministic, say);
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
  Frame kept = AsKept(frame);
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
Decision CaptureRecorder::TakeOnWalk(const FrameToDecide& input) {
  Stopwatch stopwatch;
  tracked_in_a_row_ = input.track.state == tracking::TrackState::kTracking ? tracked_in_a_row_ + 1 : 0;
  PosedPhotographs::Step step;
  const bool is_stable = !record_.views().empty() || tracked_in_a_row_ >= options_.stable_frames;
  // The tracker may still discard its first map.
  if (!is_stable && walk_->TakeHeld()) Count(Reason::kTracking);
  if (is_stable) step = walk_->Decide(input, poses_.VisiblePoints(), record_.views());
  ms_decide_.push_back(1000 * stopwatch.LapSeconds());
  if (recording_) {
    if (const auto ended = walk_->Take(step, input)) RecordAndCount(*ended);
    if (step.replaces) Count(Reason::kCovered);
  } else if (step.decision.reason == Reason::kRecorded) {
    step.decision.reason = Reason::kPaused;
  }
  if (step.decision.reason != Reason::kRecorded) Count(step.decision.reason);
  return step.decision;
}

void CaptureRecorder::Measure(const FrameToDecide& input) {
  if (!ShowsWholeSubject(input, record_.map().get())) return;
  const std::optional<MeasuredFrame> measured = record_.Measure(input.frame, lens_.live(), input.track);
  if (measured) ms_measure_.push_back(measured->processor_ms);
}

Reason CaptureRecorder::RecordOrAsk(const FrameToDecide& input, const Decision& decision) {
  if (!recording_) return Reason::kPaused;
  if (!stills_)
    return Record(input.frame, input.track, decision, DistanceToSubject(input.track)) ? Reason::kRecorded
                                                                                      : DiskReason();
  if (record_.spool().Pause()) return DiskReason();
  stills_->RequestStill();
  return Reason::kStill;
}

Decision CaptureRecorder::TakeOnSubject(FrameToDecide input) {
  Stopwatch stopwatch;
  input.exposure_settled = ExposureIsSettled(input.frame, input.track);
  double seconds = stopwatch.LapSeconds();
  Measure(input);
  stopwatch.LapSeconds();
  Decision decision = Decide(input, record_.map().get());
  seconds += stopwatch.LapSeconds();
  ms_decide_.push_back(1000 * seconds);
  if (stills_) stills_->Follow(input.frame, input.track);
  if (decision.reason == Reason::kRecorded) decision.reason = RecordOrAsk(input, decision);
  Count(decision.reason);
  return decision;
}

Frame CaptureRecorder::AsKept(const Frame& frame) const {
  Frame kept = frame;  // shares the pixels: no device writes into them again
  if (options_.deterministic) kept.host_time_s = kept.device_time_s;
  return kept;
}

// What the tracker takes as a keyframe shows something that those before did not.
void CaptureRecorder::KeepApart(const Frame& frame, const tracking::Track& track) {
  if (!options_.keep_apart || !recording_ || track.state != tracking::TrackState::kApart || !track.keyframe ||
      track.sharpness < kLeastSharpness || record_.spool().Pause())
    return;
  record_.spool().KeepUnposed(AsKept(frame));
  ++kept_apart_;
}

Decision CaptureRecorder::Take(const Frame& frame, const tracking::Track& track, double frame_period_s) {
  newest_id_.reset();
  zoom_moved_ = track.focal_ratio.has_value();
  if (bracket_ && bracket_->Take(frame, track)) {
    if (stills_) stills_->Follow(frame, track);
    Count(Reason::kBracket);
    return {Reason::kBracket, {}};
  }
  KeepApart(frame, track);
  const FrameToDecide input{.frame = frame,
                            .track = track,
                            .camera = lens_.live(),
                            .frame_period_s = frame_period_s,
                            .coverage_width_px = options_.coverage_width_px};
  return walk_ ? TakeOnWalk(input) : TakeOnSubject(input);
}

void CaptureRecorder::TakeStill(const Frame& still) {
  if (still.asked_stops) {
    const auto track = stills_ ? stills_->Find(still) : std::nullopt;
    if (stills_) stills_->NoteArrived(still, track.has_value());
    if (!bracket_ || !bracket_->TakeStill(still, track)) record_.spool().KeepUnposed(still);
    return;
  }
  const StillVerdict verdict = stills_ ? stills_->Judge(still, record_.map().get()) : StillVerdict{};
  if (verdict.decision.reason == Reason::kRecorded)
    Record(still, *verdict.track, verdict.decision, DistanceToSubject(*verdict.track));
  else
    record_.spool().KeepUnposed(still, zoom_moved_ ? "it was taken with the zoom moved" : "");
  if (stills_) stills_->Note(still, verdict);
}

}  // namespace ulf::coverage
