#include "coverage/session/capture_session.h"

#include <spdlog/spdlog.h>

#include <chrono>
#include <exception>
#include <utility>

#include "core/base/counted.h"
#include "core/base/host_time.h"
#include "core/base/quantile.h"
#include "core/light_field/folder/light_field_writer.h"
#include "coverage/session/running_capture.h"
#include "tracking/tracker/track.h"

namespace ulf::coverage {

namespace {

using Clock = std::chrono::steady_clock;

}  // namespace

std::optional<StoppedBecause> RunningCapture::TakeStill(const Frame& still) {
  if (hooks_.keep_frame) hooks_.keep_frame(still);
  if (subject_.IsStale())
    record_.spool().KeepUnposed(still);
  else
    recorder_.TakeStill(still);
  Show(hooks_.while_waiting);
  return !recorder_.AwaitsExposures() && record_.IsCapCovered(options_.until_share, poses_)
             ? std::optional(StoppedBecause::kCovered)
             : std::nullopt;
}

std::optional<StoppedBecause> RunningCapture::StopReason() const {
  if (hooks_.stop_requested && hooks_.stop_requested()) return StoppedBecause::kSignal;
  if (finish_asked_) return StoppedBecause::kClosed;
  if (record_.spool().Failure()) return StoppedBecause::kDisk;
  if (options_.max_frames > 0 && summary_.frames >= options_.max_frames) return StoppedBecause::kFrames;
  if (options_.max_seconds > 0 && meters_.DeviceSeconds() >= options_.max_seconds)
    return StoppedBecause::kSeconds;
  return std::nullopt;
}

std::optional<Frame> RunningCapture::NextFrame() {
  if (first_.empty()) return device_.Next(std::chrono::milliseconds(100));
  std::optional<Frame> frame(std::move(first_.front()));
  first_.pop_front();
  return frame;
}

std::optional<StoppedBecause> RunningCapture::TakeFrame() {
  const std::optional<Frame> frame = NextFrame();
  TakeEvents();
  if (!frame) {
    Show(hooks_.while_waiting);
    if (device_.State() == acquisition::DeviceState::kEnded) return StoppedBecause::kEnded;
    if (device_.State() == acquisition::DeviceState::kLost) return StoppedBecause::kDeviceLost;
    return std::nullopt;
  }
  if (frame->kind == FrameKind::kStill) return TakeStill(*frame);
  if (frame->status != FrameStatus::kComplete) return std::nullopt;  // the device counts them
  ++summary_.frames;
  if (hooks_.keep_frame) hooks_.keep_frame(*frame);
  const double now_s = frame->device_time_s;
  gaps_.FrameCame(now_s, device_.IsLive(), meters_.frame_period_s());
  meters_.FrameAt(now_s);

  const auto start = Clock::now();
  const Frame as_tracked = recorder_.ForTracking(*frame);
  const tracking::Track track = poses_.Step(as_tracked);
  ms_track_.push_back(1000 * SecondsSince(start));
  latest_ = {as_tracked.image, track, {}, {}};
  if (track.cam_from_world) last_turn_ = track.cam_from_world->rotation;
  if (track.state == tracking::TrackState::kInitializing)
    last_turn_.reset();  // in the world of a map that is gone
  if (track.start) ++summary_.start_obstacles[track.start->obstacle];
  gaps_.Tracking(track.state == tracking::TrackState::kTracking, now_s);
  FollowLens(track);
  if (!options_.without_subject) subject_.FindFirst(track);
  AnnouncePrediction();
  NoteZoom(track);
  if (turntable_)
    if (const std::string words = turntable_->Update(now_s, track.cam_from_world); !words.empty()) Say(words);
  LookForMistakes(*frame);
  UpdatePreflight(*frame);
  BeginWhenPossible();
  subject_.Watch(track, now_s);
  latest_.decision = recorder_.Take(*frame, TrackToRecord(track), meters_.frame_period_s());
  if (recorder_.newest_id()) subject_.RecordedFrom(track);
  UpdateCapWatch(track, latest_.decision);
  ProposeSubject();
  gaps_.Disk(record_.spool().Pause(), now_s);
  // A closed loop moves views at once by the whole drift.
  poses_due_ |= std::exchange(map_revision_, track.map_revision) != track.map_revision ||
                summary_.frames % static_cast<std::uint64_t>(options_.frames_between_pose_updates) == 0;
  if (poses_due_) poses_due_ = !CorrectPoses(false);
  if (hooks_.after_frame) {
    std::optional<CriterionView> here;
    if (track.cam_from_world && subject_.IsPlaced())
      here = CriterionView::From(lens_.recorded(), *track.cam_from_world, options_.coverage_width_px);
    if (!IsTaken(source_)) latest_.guidance = guide_.Update(record_.map().get(), here, now_s);
    Show(hooks_.after_frame);
  }
  // Also after frames that were not recorded: corrected poses, a new subject or a resumed capture may cover
  // it.
  if (!recorder_.AwaitsExposures() && record_.IsCapCovered(options_.until_share, poses_))
    return StoppedBecause::kCovered;
  return std::nullopt;
}

void RunningCapture::Close() {
  for (const std::string& line : repeated_.Finish()) Say(line);
  SayClosing("the last adjustment of poses and points");
  try {
    poses_.Finish();
  } catch (const std::exception& error) {
    spdlog::warn("the last adjustment of the map failed ({}); poses stay as they were tracked", error.what());
  }
  if (const auto before = lens_.UpdateAfterFinish(poses_)) ReplaceLens(*before, true);
  const tracking::TrackerStatistics known = poses_.Statistics();
  summary_.calibration = known.calibration;
  summary_.rolling_shutter = known.rolling_shutter;
  summary_.refined_lens = lens_.found();
  mistakes_.Finish(known.calibration, known.rolling_shutter);
  summary_.mistakes = mistakes_.noticed();
  CorrectPoses(true);
  gaps_.End(meters_.last_time_s());
  summary_.pauses = gaps_.pauses();
  summary_.paused_s = gaps_.paused_s();
  constexpr std::size_t kTakesLong = 10;  // guessed: below this the wait is hardly noticed
  if (const std::size_t waiting = record_.spool().PicturesWaiting(); waiting > kTakesLong)
    Say(fmt::format("all views are on disk; {} of images/ still to be made", Counted(waiting, "photograph")));
  std::map<std::string, std::uint64_t> reasons;
  for (const Reason reason : kReasons)
    reasons[Name(reason)] = recorder_.reasons()[static_cast<std::size_t>(reason)];
  const double device_s = meters_.DeviceSeconds();
  static_cast<ClosedRecord&>(summary_) =
      record_.Close(device_s > 0 ? device_s : ended_after_s_, reasons, poses_.Points(),
                    options_.still_camera ? std::nullopt : known.rolling_shutter,
                    [this](const std::string& step) { SayClosing(step); });
  if (options_.still_camera) summary_.stills.recorded = summary_.recorded;
  if (!summary_.problem.empty()) summary_.stopped_because = StoppedBecause::kDisk;
}

CaptureSummary RunningCapture::Run() {
  if (const auto subject = options_.subject ? options_.subject : record_.ResumedSubject())
    subject_.Set(*subject);
  waits_to_begin_ = options_.begins_on_request && record_.views().empty();
  if (waits_to_begin_) recorder_.SetRecording(false);
  const auto started = Clock::now();
  std::exception_ptr failure;
  try {
    while (!ended_) {
      AnswerRequests();
      ended_ = StopReason();
      if (!ended_) ended_ = TakeFrame();
    }
    Show(hooks_.while_waiting);
  } catch (...) {
    failure = std::current_exception();  // the light field is closed first
    ended_ = StoppedBecause::kDeviceLost;
  }
  ended_after_s_ = options_.deterministic ? 0 : SecondsSince(started);
  try {
    device_.Stop();
    // Photographs that are on their way, or came before the end was asked for.
    for (const Frame& frame : std::exchange(first_, {}))
      if (frame.kind == FrameKind::kStill) TakeStill(frame);
    recorder_.RecordHeld();
    while (const auto frame =
               options_.still_camera ? device_.Next(std::chrono::milliseconds(0)) : std::nullopt)
      if (frame->kind == FrameKind::kStill) TakeStill(*frame);
  } catch (...) {
    if (!failure) failure = std::current_exception();
  }
  recorder_.FinishBracket();
  summary_.stills = recorder_.stills();
  summary_.brackets = recorder_.brackets();
  summary_.kept_apart = recorder_.kept_apart();
  summary_.stopped_because = *ended_;
  summary_.source = source_;
  Close();
  if (failure) std::rethrow_exception(failure);
  summary_.device = device_.Statistics();
  summary_.ms_track_median = Median(ms_track_);
  summary_.ms_decide_median = Median(recorder_.ms_decide());
  summary_.reasons = recorder_.reasons();
  if (record_.errors() && !recorder_.ms_measure().empty())
    summary_.measured = MeasuredSummary{.frames = recorder_.ms_measure().size(),
                                        .ms_median = Median(recorder_.ms_measure()),
                                        .cover = options_.cover,
                                        .errors = Summarize(*record_.errors(), options_.cover.db)};
  summary_.last_recorded = recorder_.newest_view();
  summary_.subject = record_.subject();
  summary_.subject_was_found = subject_.IsFoundAutomatically();
  summary_.map = record_.map();
  summary_.errors = record_.errors();
  return std::move(summary_);
}

CaptureSummary RunCapture(acquisition::Device& device, const CameraModel& camera, tracking::PoseSource& poses,
                          LightFieldWriter writer, const CaptureOptions& options, const CaptureHooks& hooks,
                          std::vector<Frame> first) {
  ExposureMatch light(writer.Contents());
  return RunningCapture(device, camera, poses, std::move(writer), std::move(light), options, hooks,
                        std::move(first))
      .Run();
}

}  // namespace ulf::coverage
