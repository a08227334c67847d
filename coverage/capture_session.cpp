#include "coverage/capture_session.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <deque>
#include <exception>
#include <iterator>
#include <utility>
#include <variant>

#include "acquisition/counted.h"
#include "coverage/cap_watch.h"
#include "coverage/capture_gaps.h"
#include "coverage/capture_meters.h"
#include "coverage/capture_outlook.h"
#include "coverage/capture_record.h"
#include "coverage/capture_subject.h"
#include "coverage/exposure_match.h"
#include "coverage/exposure_watch.h"
#include "coverage/posed_photographs.h"
#include "coverage/sphere_outline.h"
#include "tracking/quantile.h"
#include "tracking/track_words.h"

namespace ulf {
namespace {

using Clock = std::chrono::steady_clock;

constexpr char kNoSubjectToPlace[] = "this capture has no subject to place (--no-subject)";

double MillisecondsSince(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

class Session {
 public:
  Session(Device& device, const CameraModel& camera, PoseSource& poses, LightFieldWriter writer,
          const CaptureOptions& options, const CaptureHooks& hooks, std::vector<Frame> first);
  CaptureSummary Run();

 private:
  // The latest frame that got as far as a decision, and what became of it.
  struct Looked {
    Image live;
    Track track;
    Decision decision;
    std::optional<int> recorded_view;
    Guidance guidance;
  };
  std::optional<StoppedBecause> Enough() const;
  std::optional<Frame> NextFrame();
  std::optional<StoppedBecause> TakeFrame();
  void NoteTime(const Frame& frame);
  std::optional<StoppedBecause> TakeStill(const Frame& still);
  Decision DecideAndRecord(const Frame& frame, const Track& track);
  Decision DecideOnAWalk(const Frame& frame, const Track& track);
  void RecordHeld(const HeldFrame& held);
  double DistanceOfTheSeen(const Track& track) const;
  std::optional<int> Record(const Frame& frame, const Track& track, const Decision& decision);
  Reason ReasonOfTheDisk();
  void WatchTheCap(const Track& track, const Decision& decision);

  void SayWhatToExpect();
  void CheckBeforeFirstView(const Frame& frame);
  std::optional<double> PoseErrorNow() const;
  bool ExposureIsSettled(const Frame& frame, const Track& track);

  void AnswerRequests();
  void Answer(const TakeBackLast& asked);
  void Answer(const TakeBackViews& asked);
  void Answer(const PlaceSubject& asked);
  void Answer(const FindSubject& asked);
  void Answer(const SetRecording& asked);
  void Answer(const FinishCapture& asked);

  void TakeEvents();
  void Say(const std::string& text);
  std::string DeviceProblem() const;
  SharedCaptureState State();
  void Show(const std::function<void(const SharedCaptureState&)>& look);

  void Close();

  Device& device_;
  const CameraModel camera_;  // of the frames that are tracked
  PoseSource& poses_;
  const CaptureOptions options_;
  const CameraModel recorded_camera_;
  std::optional<StillCapture> stills_;
  const CaptureHooks& hooks_;
  std::deque<Frame> first_;  // before the device is asked
  const std::filesystem::path root_;
  ExposureMatch light_;
  CaptureRecord record_;
  CaptureOutlook outlook_;
  CaptureSubject subject_;
  CaptureGaps gaps_;
  CaptureMeters meters_;

  std::optional<PosedPhotographs> walk_;
  int tracked_in_a_row_ = 0;
  ExposureWatch exposure_;
  CapWatch cap_watch_{options_.until_share};
  CaptureSummary summary_;
  std::vector<double> ms_track_, ms_decide_;
  std::optional<double> first_time_s_, last_time_s_;
  double frame_period_s_ = 0;
  int map_revision_ = 0;  // of the tracker, as last seen
  bool poses_due_ = false;
  bool recording_ = true;
  std::uint64_t requests_answered_ = 0;
  bool finish_asked_ = false;
  std::optional<StoppedBecause> ended_;
  Looked looked_;
  Guide guide_;
  std::vector<std::string> said_;  // of late
  std::uint64_t times_said_ = 0;
  double ended_after_s_ = 0;  // by this machine's clock
};

Session::Session(Device& device, const CameraModel& camera, PoseSource& poses, LightFieldWriter writer,
                 const CaptureOptions& options, const CaptureHooks& hooks, std::vector<Frame> first)
    : device_(device),
      camera_(camera),
      poses_(poses),
      options_(options),
      recorded_camera_(options.still_camera.value_or(camera)),
      hooks_(hooks),
      first_(std::make_move_iterator(first.begin()), std::make_move_iterator(first.end())),
      root_(writer.Contents().root),
      light_(writer.Contents()),
      record_(std::move(writer),
              {.camera = recorded_camera_,
               .coverage_width_px = options.coverage_width_px,
               .map = {.cap = options.cap, .threshold_px = options.threshold_px},
               .spool_views = options.spool_views,
               .deterministic = options.deterministic},
              [this](const std::string& text) { Say(text); }),
      outlook_([this](const std::string& text) { Say(text); }),
      subject_(record_, outlook_, poses_, camera_,
               {.size = options.subject_size,
                .rectangle_share = options.limits.rectangle_share,
                .stable_frames = options.stable_frames},
               [this](const std::string& text) { Say(text); }),
      gaps_(record_.spool(), [this](const std::string& text) { Say(text); }) {
  if (options.without_subject) walk_.emplace(camera, *options.without_subject);
  if (options.still_camera)
    stills_.emplace(device_, *options.still_camera, poses_, options_.limits, options_.coverage_width_px);
}

void Session::SayWhatToExpect() {
  if (!record_.map() || !outlook_.IsDue() || !looked_.track.cam_from_world) return;
  const Subject& subject = record_.map()->subject();
  const double distance = (*looked_.track.cam_from_world * subject.center_in_world).norm();
  outlook_.Expect(
      SetupAt(recorded_camera_, options_.coverage_width_px, subject, distance, options_.threshold_px),
      options_.cap, options_.until_share, poses_.IsMetric());
}

void Session::CheckBeforeFirstView(const Frame& frame) {
  if (!record_.views().empty() || (outlook_.IsDue() && !walk_)) return;
  const double of_the_frame = static_cast<double>(recorded_camera_.width) * recorded_camera_.height /
                              (static_cast<double>(camera_.width) * camera_.height);
  outlook_.Check({.calibrated = options_.calibrated,
                  .calibration_source = options_.calibration_source,
                  .held = device_.Held(),
                  .prediction = {},
                  .cap = options_.cap,
                  .without_subject = walk_.has_value(),
                  .bytes_per_view = static_cast<std::uint64_t>(
                      of_the_frame * static_cast<double>(ViewSpool::MostBytes(frame))),
                  .disk_left_bytes = meters_.DiskLeftBytes(root_),
                  .has_pose = looked_.track.cam_from_world.has_value(),
                  .pose_error_px = PoseErrorNow(),
                  .most_pose_error_px = options_.limits.max_pose_error_px});
}

std::optional<double> Session::PoseErrorNow() const {
  const Track& track = looked_.track;
  if (!record_.map() || !track.cam_from_world || !track.center_sigma) return std::nullopt;
  const Subject& subject = record_.map()->subject();
  return PoseErrorPx(*track.center_sigma,
                     CriterionView::From(recorded_camera_, {}, options_.coverage_width_px).fx,
                     (*track.cam_from_world * subject.center_in_world).norm(), subject.radius);
}

bool Session::ExposureIsSettled(const Frame& frame, const Track& track) {
  if (!record_.map() || !track.cam_from_world) return true;
  return exposure_.Settled(frame, camera_, *track.cam_from_world, record_.map()->subject(),
                           device_.Held().exposure);
}

double Session::DistanceOfTheSeen(const Track& track) const {
  if (record_.map()) return (*track.cam_from_world * record_.map()->subject().center_in_world).norm();
  return MedianDepth(poses_.VisiblePoints()).value_or(1);
}

std::optional<int> Session::Record(const Frame& frame, const Track& track, const Decision& decision) {
  Frame kept = frame;  // its pixels are shared: no device writes into them again
  if (options_.deterministic) kept.host_time_s = kept.device_time_s;
  const bool light_is_matched = kept.exposure_s <= 0 && device_.Held().exposure != true;
  if (light_is_matched)
    kept.gain = light_.GainOf(kept.image, recorded_camera_, *track.cam_from_world, DistanceOfTheSeen(track));
  looked_.recorded_view = record_.Add(kept, track, decision.bound_px, poses_);
  if (light_is_matched && looked_.recorded_view) light_.Keep(*looked_.recorded_view, *track.cam_from_world);
  if (looked_.recorded_view)
    summary_.last_recorded = std::make_shared<RecordedView>(
        RecordedView{*looked_.recorded_view, std::move(kept), recorded_camera_, *track.cam_from_world});
  return looked_.recorded_view;
}

Reason Session::ReasonOfTheDisk() {
  const auto pause = record_.spool().Pause();
  return pause && pause->disk_is_full ? Reason::kDisk : Reason::kSpool;
}

void Session::WatchTheCap(const Track& track, const Decision& decision) {
  if (!record_.map() || !track.cam_from_world) return;
  const bool would_record = decision.reason == Reason::kCovered || decision.reason == Reason::kRecorded;
  const auto hopeless =
      cap_watch_.After(*record_.map(), track.cam_from_world->OriginInSource(), would_record && recording_);
  if (hopeless) Say(*hopeless);
}

void Session::RecordHeld(const HeldFrame& held) {
  const bool recorded = Record(held.frame, held.track, {Reason::kRecorded, {}}).has_value();
  ++summary_.reasons[static_cast<std::size_t>(recorded ? Reason::kRecorded : ReasonOfTheDisk())];
}

// A frame that is held is counted when it is known what becomes of it.
Decision Session::DecideOnAWalk(const Frame& frame, const Track& track) {
  const auto start = Clock::now();
  const auto count = [&](Reason reason) { ++summary_.reasons[static_cast<std::size_t>(reason)]; };
  tracked_in_a_row_ = track.state == TrackState::kTracking ? tracked_in_a_row_ + 1 : 0;
  PosedPhotographs::Step step;
  if (record_.views().empty() &&
      tracked_in_a_row_ < options_.stable_frames) {  // the map may yet be thrown away
    if (walk_->TakeHeld()) count(Reason::kTracking);
  } else {
    step = walk_->After({.frame = frame,
                         .track = track,
                         .camera = camera_,
                         .frame_period_s = frame_period_s_,
                         .coverage_width_px = options_.coverage_width_px},
                        poses_.VisiblePoints(), record_.views(), options_.limits);
  }
  ms_decide_.push_back(MillisecondsSince(start));
  if (step.record) RecordHeld(*step.record);
  if (step.replaced) count(Reason::kCovered);
  if (step.decision.reason == Reason::kRecorded && !recording_) {
    walk_->TakeHeld();
    step.decision.reason = Reason::kPaused;
  }
  if (step.decision.reason != Reason::kRecorded) count(step.decision.reason);
  return step.decision;
}

Decision Session::DecideAndRecord(const Frame& frame, const Track& track) {
  if (walk_) return DecideOnAWalk(frame, track);
  const auto start = Clock::now();
  const bool exposure_settled = ExposureIsSettled(frame, track);
  Decision decision = Decide({.frame = frame,
                              .track = track,
                              .camera = camera_,
                              .frame_period_s = frame_period_s_,
                              .coverage_width_px = options_.coverage_width_px,
                              .exposure_settled = exposure_settled},
                             record_.map(), options_.limits);
  ms_decide_.push_back(MillisecondsSince(start));
  if (stills_) stills_->Follow(frame, track);
  if (decision.reason == Reason::kRecorded) {
    if (!recording_) {
      decision.reason = Reason::kPaused;
    } else if (stills_) {
      decision.reason = record_.spool().Pause() ? ReasonOfTheDisk() : Reason::kStill;
      if (decision.reason == Reason::kStill) stills_->Ask();
    } else if (!Record(frame, track, decision)) {
      decision.reason = ReasonOfTheDisk();
    }
  }
  ++summary_.reasons[static_cast<std::size_t>(decision.reason)];
  return decision;
}

std::optional<StoppedBecause> Session::TakeStill(const Frame& still) {
  if (hooks_.keep_frame) hooks_.keep_frame(still);
  const StillVerdict verdict = stills_ ? stills_->Judge(still, record_.map()) : StillVerdict{};
  if (verdict.decision.reason != Reason::kRecorded)
    record_.spool().KeepUnposed(still);
  else
    Record(still, *verdict.track, verdict.decision);
  Show(hooks_.while_waiting);
  return record_.CapIsCovered(options_.until_share, poses_) ? std::optional(StoppedBecause::kCovered)
                                                            : std::nullopt;
}

void Session::Say(const std::string& text) {
  constexpr std::size_t kReadAtOnce = 3;
  said_.push_back(text);
  if (said_.size() > kReadAtOnce) said_.erase(said_.begin());
  ++times_said_;
  if (hooks_.say) hooks_.say(text);
}

void Session::TakeEvents() {
  for (const DeviceEvent& event : device_.TakeEvents()) {
    ++summary_.events[Name(event.kind)];
    Say(event.text);
    if (event.kind == DeviceEventKind::kFaulted && last_time_s_)
      gaps_.DeviceFaulted(*last_time_s_, event.text);
  }
}

void Session::AnswerRequests() {
  if (!hooks_.requests) return;
  for (const CaptureRequest& request : hooks_.requests->Take()) {
    std::visit([this](const auto& asked) { Answer(asked); }, request);
    ++requests_answered_;
  }
}

void Session::Answer(const TakeBackLast& asked) {
  const std::size_t there = record_.views().Ids().size();
  if (asked.count > 1 && static_cast<std::size_t>(asked.count) > there)
    return Say(fmt::format("nothing was taken back: {} asked for, there are {}; ask for as many or fewer",
                           Counted(static_cast<std::size_t>(asked.count), "view"), there));
  summary_.taken_back += record_.TakeBack(record_.views().LastIds(asked.count));
}

void Session::Answer(const TakeBackViews& asked) { summary_.taken_back += record_.TakeBack(asked.ids); }

void Session::Answer(const PlaceSubject& asked) {
  if (walk_) return Say(kNoSubjectToPlace);
  subject_.Place(asked.subject, looked_.track.cam_from_world);
}

void Session::Answer(const FindSubject& asked) {
  if (walk_) return Say(kNoSubjectToPlace);
  subject_.Find(asked, looked_.track.cam_from_world);
}

void Session::Answer(const SetRecording& asked) {
  recording_ = asked.on;
  if (last_time_s_) gaps_.Recording(asked.on, *last_time_s_);
  Say(asked.on ? "recording" : "recording paused, tracking goes on");
}

void Session::Answer(const FinishCapture&) {
  finish_asked_ = true;
  Say("finishing, as asked");
}

std::string Session::DeviceProblem() const {
  const DeviceState state = device_.State();
  if (state != DeviceState::kFaulted && state != DeviceState::kReconnecting) return {};
  return fmt::format("{}: {}", Name(state), device_.Info().problem);
}

SharedCaptureState Session::State() {
  auto state = std::make_shared<CaptureState>();
  state->frames = summary_.frames;
  state->device_time_s = last_time_s_.value_or(0);
  state->frames_per_s = meters_.FramesPerS();
  state->dropped = meters_.Dropped(device_);
  state->disk_left_bytes = meters_.DiskLeftBytes(root_);

  const Track& track = looked_.track;
  state->live = looked_.live;
  state->camera = camera_;
  state->takes_stills = stills_.has_value();
  state->tracking = track.state;
  if (track.state != TrackState::kTracking) state->tracking_words = InWords(track);
  state->cam_from_world = track.cam_from_world;
  state->quality = track.quality;
  state->start = track.start;
  if (track.cam_from_world) state->points = poses_.VisiblePoints();

  state->without_subject = walk_.has_value();
  state->finding_subject = subject_.Finding();
  record_.Describe(*state);
  outlook_.Describe(*state);
  state->rectangle_share = options_.limits.rectangle_share;
  state->newest_view = summary_.last_recorded;
  state->light_field = root_;
  state->guidance = looked_.guidance;
  state->subject_moved = subject_.Moved();

  state->decision = looked_.decision;
  state->recording = recording_;
  state->recorded_view = looked_.recorded_view;
  state->device_problem = DeviceProblem();
  if (!state->device_problem.empty())
    state->why_waiting = "waiting for the device, " + state->device_problem;
  else if (const std::string disk = gaps_.DiskReason(); !disk.empty())
    state->why_waiting = "recording paused: " + disk;
  state->exposure_locked = device_.Held().exposure;
  state->said = said_;
  state->times_said = times_said_;
  state->requests_answered = requests_answered_;
  state->ended = ended_;
  return state;
}

void Session::Show(const std::function<void(const SharedCaptureState&)>& look) {
  if (!look) return;
  look(State());
  looked_.recorded_view.reset();
}

std::optional<StoppedBecause> Session::Enough() const {
  if (hooks_.stop_requested && hooks_.stop_requested()) return StoppedBecause::kSignal;
  if (finish_asked_) return StoppedBecause::kClosed;
  if (record_.spool().Failure()) return StoppedBecause::kDisk;
  if (options_.max_frames > 0 && summary_.frames >= options_.max_frames) return StoppedBecause::kFrames;
  if (options_.max_seconds > 0 && first_time_s_ && *last_time_s_ - *first_time_s_ >= options_.max_seconds)
    return StoppedBecause::kSeconds;
  return std::nullopt;
}

std::optional<Frame> Session::NextFrame() {
  if (first_.empty()) return device_.Next(std::chrono::milliseconds(100));
  std::optional<Frame> frame(std::move(first_.front()));
  first_.pop_front();
  return frame;
}

void Session::NoteTime(const Frame& frame) {
  gaps_.FrameCame(frame.device_time_s, device_.IsLive(), frame_period_s_);
  if (last_time_s_) {
    // The shortest recent time between frames: a dropped one must not look like a slow camera.
    const double step_s = frame.device_time_s - *last_time_s_;
    if (step_s > 0) frame_period_s_ = frame_period_s_ > 0 ? std::min(step_s, 1.1 * frame_period_s_) : step_s;
  }
  last_time_s_ = frame.device_time_s;
  if (!first_time_s_) first_time_s_ = last_time_s_;
  meters_.FrameAt(frame.device_time_s);
}

std::optional<StoppedBecause> Session::TakeFrame() {
  const std::optional<Frame> frame = NextFrame();
  TakeEvents();
  if (!frame) {
    Show(hooks_.while_waiting);
    if (device_.State() == DeviceState::kEnded) return StoppedBecause::kEnded;
    if (device_.State() == DeviceState::kLost) return StoppedBecause::kDeviceLost;
    return std::nullopt;
  }
  if (frame->kind == FrameKind::kStill) return TakeStill(*frame);
  if (frame->status != FrameStatus::kComplete) return std::nullopt;  // the device counts them
  ++summary_.frames;
  if (hooks_.keep_frame) hooks_.keep_frame(*frame);
  NoteTime(*frame);

  const auto start = Clock::now();
  const Track track = poses_.Step(*frame);
  ms_track_.push_back(MillisecondsSince(start));
  looked_ = {frame->image, track, {}, {}, {}};
  gaps_.Tracking(track.state == TrackState::kTracking, *last_time_s_);
  if (!walk_) subject_.FindFirst(track);
  SayWhatToExpect();
  CheckBeforeFirstView(*frame);
  subject_.Watch(track, *last_time_s_);
  looked_.decision = DecideAndRecord(*frame, track);
  WatchTheCap(track, looked_.decision);
  gaps_.Disk(record_.spool().Pause(), *last_time_s_);
  // A closed loop moves views at once by what drift had come to.
  poses_due_ |= std::exchange(map_revision_, track.map_revision) != track.map_revision ||
                summary_.frames % static_cast<std::uint64_t>(options_.frames_between_pose_updates) == 0;
  if (poses_due_) poses_due_ = !record_.CorrectPoses(poses_, false);
  if (hooks_.after_frame) {
    std::optional<CriterionView> here;
    if (track.cam_from_world)
      here = CriterionView::From(recorded_camera_, *track.cam_from_world, options_.coverage_width_px);
    looked_.guidance = guide_.After(record_.map(), here, *last_time_s_);
    Show(hooks_.after_frame);
  }
  // Not only where this frame was recorded: poses are corrected, subjects placed, light fields resumed.
  if (record_.CapIsCovered(options_.until_share, poses_)) return StoppedBecause::kCovered;
  return std::nullopt;
}

void Session::Close() {
  try {
    poses_.Finish();
  } catch (const std::exception& error) {
    spdlog::warn("the last adjustment failed ({}); poses stay as they were tracked", error.what());
  }
  const TrackerStatistics known = poses_.Statistics();
  summary_.calibration = known.calibration;
  summary_.rolling_shutter = known.rolling_shutter;
  record_.CorrectPoses(poses_, true);
  gaps_.End(last_time_s_);
  summary_.pauses = gaps_.pauses();
  summary_.paused_s = gaps_.paused_s();
  if (const std::size_t following = record_.spool().PicturesWaiting(); following > 10)
    Say(fmt::format("everything recorded is on disk; {} of images/ to be made",
                    Counted(following, "photograph")));
  std::map<std::string, std::uint64_t> reasons;
  for (const Reason reason : kReasons)
    reasons[Name(reason)] = summary_.reasons[static_cast<std::size_t>(reason)];
  const double device_s = first_time_s_ ? *last_time_s_ - *first_time_s_ : 0;
  const ClosedRecord closed =
      record_.Close(device_s > 0 ? device_s : ended_after_s_, reasons, poses_.Points());
  summary_.recorded = closed.recorded;
  summary_.unwritten = closed.unwritten;
  summary_.set_aside = closed.set_aside;
  if (stills_) summary_.stills.recorded = summary_.recorded;
  if (closed.problem.empty()) return;
  summary_.stopped_because = StoppedBecause::kDisk;
  summary_.problem = closed.problem;
}

CaptureSummary Session::Run() {
  if (const auto subject = options_.subject ? options_.subject : record_.ResumedSubject())
    subject_.Set(*subject);
  const auto started = Clock::now();
  std::exception_ptr failure;
  try {
    while (!ended_) {
      AnswerRequests();
      ended_ = Enough();
      if (!ended_) ended_ = TakeFrame();
    }
    Show(hooks_.while_waiting);
  } catch (...) {
    failure = std::current_exception();  // whatever broke: what was recorded is closed first
    ended_ = StoppedBecause::kDeviceLost;
  }
  ended_after_s_ = options_.deterministic ? 0 : MillisecondsSince(started) / 1000;
  try {
    device_.Stop();
    // Photographs that were on their way, or came before the end was asked for.
    for (const Frame& frame : std::exchange(first_, {}))
      if (frame.kind == FrameKind::kStill) TakeStill(frame);
    if (const auto held = walk_ ? walk_->TakeHeld() : std::nullopt) RecordHeld(*held);
    while (const auto frame = stills_ ? device_.Next(std::chrono::milliseconds(0)) : std::nullopt)
      if (frame->kind == FrameKind::kStill) TakeStill(*frame);
  } catch (...) {
    if (!failure) failure = std::current_exception();
  }
  if (stills_) summary_.stills = stills_->counts();
  summary_.stopped_because = *ended_;
  Close();
  if (failure) std::rethrow_exception(failure);
  summary_.device = device_.Statistics();
  summary_.ms_track_median = Median(ms_track_);
  summary_.ms_decide_median = Median(ms_decide_);
  summary_.subject = record_.subject();
  summary_.subject_was_found = subject_.FoundByItself();
  summary_.map = record_.SharedMap();
  return std::move(summary_);
}

}  // namespace

CaptureSummary RunCapture(Device& device, const CameraModel& camera, PoseSource& poses,
                          LightFieldWriter writer, const CaptureOptions& options, const CaptureHooks& hooks,
                          std::vector<Frame> first) {
  return Session(device, camera, poses, std::move(writer), options, hooks, std::move(first)).Run();
}

}  // namespace ulf
