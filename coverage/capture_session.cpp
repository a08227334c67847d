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
#include "coverage/capture_gaps.h"
#include "coverage/capture_meters.h"
#include "coverage/capture_prediction.h"
#include "coverage/exposure_watch.h"
#include "coverage/held_views.h"
#include "coverage/reopened.h"
#include "coverage/sphere_outline.h"
#include "coverage/subject_finder.h"
#include "coverage/subject_watch.h"
#include "tracking/track_words.h"

namespace ulf {
namespace {

using Clock = std::chrono::steady_clock;

double MillisecondsSince(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

double Median(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

bool Same(const Rigid3& a, const Rigid3& b) {
  return a.rotation.coeffs() == b.rotation.coeffs() && a.translation == b.translation;
}

// "3 views (15, 16, 17)"
std::string ViewsInWords(const std::vector<int>& ids) {
  std::string text;
  for (const int id : ids) text += fmt::format("{}{}", text.empty() ? "" : ", ", id);
  return fmt::format("{} ({})", Counted(ids.size(), "view"), text);
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
  std::optional<int> Record(const Frame& frame, const Track& track, const Decision& decision);
  Reason ReasonOfTheDisk();

  void PlaceFirstSubject(const Track& track);
  void SetSubject(const Subject& subject);
  void SayWhatToExpect();
  void CheckBeforeFirstView(const Frame& frame);
  bool ExposureIsSettled(const Frame& frame, const Track& track);
  void WatchSubject(const Track& track);
  CoverageMap& MapToChange();
  double Repaint();  // the share that fell open
  std::string OfWhat() const { return options_.cap ? "of the cap" : "of what was covered"; }
  bool CorrectPoses(bool last);
  bool CapIsCovered();

  void AnswerRequests();
  void Answer(const TakeBackLast& asked);
  void Answer(const TakeBackViews& asked);
  void Answer(const PlaceSubject& asked);
  void Answer(const FindSubject& asked);
  void Answer(const SetRecording& asked);
  void Answer(const FinishCapture& asked);
  void TakeBack(const std::vector<int>& ids);
  void MoveSubject(const Subject& subject);

  void TakeEvents();
  void Say(const std::string& text);
  std::string DeviceProblem() const;
  std::optional<double> ViewsExpected() const;
  SharedCaptureState State();

  void Close();
  void CloseLightField(LightFieldWriter& writer);

  Device& device_;
  const CameraModel camera_;  // of the frames that are tracked
  PoseSource& poses_;
  const CaptureOptions options_;
  const CameraModel recorded_camera_;
  std::optional<StillCapture> stills_;
  const CaptureHooks& hooks_;
  std::deque<Frame> first_;  // before the device is asked
  const std::filesystem::path root_;
  const int first_new_id_;
  const double earlier_s_;
  const std::map<std::string, std::uint64_t> earlier_reasons_;
  std::optional<Subject> resumed_subject_;
  HeldViews views_;
  ViewSpool spool_;
  CaptureGaps gaps_;
  CaptureMeters meters_;

  std::shared_ptr<CoverageMap> map_;  // also in states that were given out: MapToChange()
  Reopened reopened_;
  std::optional<CapturePrediction> prediction_;
  std::vector<PreflightItem> preflight_;
  ExposureWatch exposure_;
  SubjectWatch subject_watch_;
  bool subject_moved_ = false;
  CaptureSummary summary_;
  std::vector<double> ms_track_, ms_decide_;
  int tracked_in_a_row_ = 0;
  std::optional<double> first_time_s_, last_time_s_;
  double frame_period_s_ = 0;
  int map_revision_ = 0;  // of the tracker, as last seen
  bool poses_due_ = false;
  bool measured_ = false;  // the coverage, since a view was added
  bool recording_ = true;
  bool finish_asked_ = false;
  Looked looked_;
  Guide guide_;
  std::string said_;
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
      first_new_id_(writer.NextViewId()),
      earlier_s_(writer.Contents().capture_s),
      earlier_reasons_(writer.Contents().reasons),
      resumed_subject_(writer.Contents().subject),
      views_(writer.Contents()),
      spool_(std::move(writer), options.spool_views, !options.deterministic),
      gaps_(spool_, [this](const std::string& text) { Say(text); }) {
  if (options.still_camera)
    stills_.emplace(device_, *options.still_camera, poses_, options_.limits, options_.coverage_width_px);
}

void Session::SetSubject(const Subject& subject) {
  summary_.subject = subject;
  if (resumed_subject_ != subject) spool_.SetSubject(subject);
  resumed_subject_.reset();
  map_ = std::make_shared<CoverageMap>(
      subject, CoverageMapOptions{.cap = options_.cap, .threshold_px = options_.threshold_px});
  map_->SetViews(views_.ForCriterion(recorded_camera_, options_.coverage_width_px));
  reopened_.Forget();
  prediction_.reset();
  subject_watch_.Forget();
  subject_moved_ = false;
  measured_ = false;
}

void Session::PlaceFirstSubject(const Track& track) {
  tracked_in_a_row_ = track.state == TrackState::kTracking ? tracked_in_a_row_ + 1 : 0;
  if (map_ || tracked_in_a_row_ < options_.stable_frames || !track.cam_from_world) return;
  if (const auto depth = DepthNearCenter(poses_.VisiblePoints(), camera_))
    SetSubject(SubjectOnAxis(camera_, *track.cam_from_world, *depth, options_.subject_size));
}

// Once the subject is there and a pose says how far away it is.
void Session::SayWhatToExpect() {
  if (!map_ || prediction_ || !looked_.track.cam_from_world) return;
  const Subject& subject = map_->subject();
  const double distance = (*looked_.track.cam_from_world * subject.center_in_world).norm();
  prediction_ =
      Predict(SetupAt(recorded_camera_, options_.coverage_width_px, subject, distance, options_.threshold_px),
              options_.cap);
  if (prediction_) Say(InWords(*prediction_, options_.threshold_px, poses_.IsMetric()));
}

// Until a view is recorded; what is not in order is said once, when all of it is known.
void Session::CheckBeforeFirstView(const Frame& frame) {
  if (!views_.empty() || !prediction_) return;
  const double of_the_frame = static_cast<double>(recorded_camera_.width) * recorded_camera_.height /
                              (static_cast<double>(camera_.width) * camera_.height);
  const bool first = preflight_.empty();
  preflight_ = Preflight({.calibrated = options_.calibrated,
                          .calibration_source = options_.calibration_source,
                          .held = device_.Held(),
                          .prediction = prediction_,
                          .bytes_per_view = static_cast<std::uint64_t>(
                              of_the_frame * static_cast<double>(ViewSpool::MostBytes(frame))),
                          .disk_left_bytes = meters_.DiskLeftBytes(root_),
                          .tracking_quality = looked_.track.quality,
                          .least_quality = options_.limits.min_tracking_quality});
  if (!first) return;
  for (const PreflightItem& item : preflight_)
    if (item.in_order == false) Say(fmt::format("before the first view: {}: {}", item.name, item.words));
}

bool Session::ExposureIsSettled(const Frame& frame, const Track& track) {
  if (!map_ || !track.cam_from_world) return true;
  return exposure_.Settled(frame, camera_, *track.cam_from_world, map_->subject());
}

void Session::WatchSubject(const Track& track) {
  if (!map_ || track.state != TrackState::kTracking) return;
  const bool moved = subject_watch_.Moved(*last_time_s_, poses_.ExpectedPoints(), map_->subject());
  if (std::exchange(subject_moved_, moved) || !moved) return;
  Say("the subject seems to have moved: views from now on do not fit the earlier ones; put it back and take "
      "back "
      "the views since then, or place the subject anew");
}

// Whoever looks at a state that has the map looks at a value: it is copied before it changes. Once nobody
// else holds it nobody can come to; holding it once more here makes what they read happen before what is
// written.
CoverageMap& Session::MapToChange() {
  if (map_.use_count() > 1)
    map_ = std::make_shared<CoverageMap>(*map_);
  else
    static_cast<void>(std::shared_ptr<CoverageMap>(map_));
  return *map_;
}

double Session::Repaint() {
  if (!map_) return 0;
  auto repainted = std::make_shared<CoverageMap>(map_->subject(), map_->options());
  repainted->SetViews(views_.ForCriterion(recorded_camera_, options_.coverage_width_px));
  const double fell_open = reopened_.Note(*map_, *repainted);
  map_ = std::move(repainted);
  return fell_open;
}

std::optional<int> Session::Record(const Frame& frame, const Track& track, const Decision& decision) {
  Frame kept = frame;  // its pixels are shared: no device writes into them again
  if (options_.deterministic) kept.host_time_s = kept.device_time_s;
  View view;
  view.cam_from_world = *track.cam_from_world;
  view.tracking_quality = track.quality;
  view.bound_px = decision.bound_px;
  const std::optional<int> id =
      frame.kind == FrameKind::kStill ? spool_.AddView(kept, view) : spool_.TryAddView(kept, view);
  if (!id) return std::nullopt;
  views_.Add({*id, track.anchor, view.cam_from_world});
  MapToChange().Add(CriterionView::From(recorded_camera_, view.cam_from_world, options_.coverage_width_px));
  reopened_.DropCovered(*map_);
  measured_ = false;
  summary_.last_recorded = RecordedFrame{std::move(kept), view.cam_from_world};
  looked_.recorded_view = id;
  return id;
}

Reason Session::ReasonOfTheDisk() {
  const auto pause = spool_.Pause();
  return pause && pause->disk_is_full ? Reason::kDisk : Reason::kSpool;
}

Decision Session::DecideAndRecord(const Frame& frame, const Track& track) {
  const auto start = Clock::now();
  const bool exposure_settled = ExposureIsSettled(frame, track);
  Decision decision = Decide({.frame = frame,
                              .track = track,
                              .camera = camera_,
                              .frame_period_s = frame_period_s_,
                              .coverage_width_px = options_.coverage_width_px,
                              .exposure_settled = exposure_settled},
                             map_.get(), options_.limits);
  ms_decide_.push_back(MillisecondsSince(start));
  if (stills_) stills_->Follow(frame, track);
  if (decision.reason == Reason::kRecorded) {
    if (!recording_) {
      decision.reason = Reason::kPaused;
    } else if (stills_) {
      decision.reason = spool_.Pause() ? ReasonOfTheDisk() : Reason::kStill;
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
  const StillVerdict verdict = stills_ ? stills_->Judge(still, map_.get()) : StillVerdict{};
  if (verdict.decision.reason != Reason::kRecorded) {
    spool_.KeepUnposed(still);
    return std::nullopt;
  }
  Record(still, *verdict.track, verdict.decision);
  return CapIsCovered() ? std::optional(StoppedBecause::kCovered) : std::nullopt;
}

void Session::Say(const std::string& text) {
  said_ = text;
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
  for (const CaptureRequest& request : hooks_.requests->Take())
    std::visit([this](const auto& asked) { Answer(asked); }, request);
}

void Session::Answer(const TakeBackLast& asked) { TakeBack(views_.LastIds(asked.count)); }

void Session::Answer(const TakeBackViews& asked) { TakeBack(asked.ids); }

void Session::TakeBack(const std::vector<int>& ids) {
  std::vector<int> taken;
  for (const int id : ids) {
    if (views_.Remove(id)) {
      spool_.RemoveView(id);
      taken.push_back(id);
    } else if (std::find(taken.begin(), taken.end(), id) == taken.end()) {
      Say(fmt::format("there is no view {} to take back", id));
    }
  }
  if (taken.empty()) {
    if (ids.empty()) Say("there is no view to take back");
    return;
  }
  std::sort(taken.begin(), taken.end());
  summary_.taken_back += taken.size();
  const double fell_open = Repaint();
  measured_ = false;
  Say(fmt::format("taken back, kept in unposed/: {}; {:.1f} % {} fell open again", ViewsInWords(taken),
                  100 * fell_open, OfWhat()));
}

void Session::Answer(const PlaceSubject& asked) {
  const std::string problem = ProblemOf(asked.subject, looked_.track.cam_from_world);
  if (!problem.empty()) return Say("the subject stays as it was: " + problem);
  MoveSubject(asked.subject);
}

void Session::Answer(const FindSubject& asked) {
  const auto& pose = looked_.track.cam_from_world;
  const double share = asked.width_share.value_or(options_.subject_size);
  if (!pose) return Say("the subject stays as it was: the camera's position is not known at the moment");
  if (!(share > 0 && share <= options_.limits.rectangle_share))
    return Say(
        fmt::format("the subject stays as it was: its sphere cannot be {:g} of the picture's width, the "
                    "safety rectangle is {:g}",
                    share, options_.limits.rectangle_share));
  const auto depth = asked.depth ? asked.depth : DepthNearCenter(poses_.VisiblePoints(), camera_);
  if (!depth)
    return Say(
        "the subject stays as it was: too few tracked points in the middle of the picture; aim at it, or "
        "give "
        "its depth (subject depth D)");
  MoveSubject(SubjectOnAxis(camera_, *pose, *depth, share));
}

void Session::MoveSubject(const Subject& subject) {
  SetSubject(subject);
  const Eigen::Vector3d& center = subject.center_in_world;
  Say(fmt::format("the subject is at {:.3g} {:.3g} {:.3g}, radius {:.3g}{}", center.x(), center.y(),
                  center.z(), subject.radius,
                  views_.empty() ? "" : fmt::format("; {} painted anew", Counted(views_.size(), "view"))));
}

void Session::Answer(const SetRecording& asked) {
  recording_ = asked.on;
  if (last_time_s_) gaps_.Recording(asked.on, *last_time_s_);
  Say(asked.on ? "recording" : "recording is paused, tracking goes on");
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

// What is recorded, and what the open rest will take.
std::optional<double> Session::ViewsExpected() const {
  if (!prediction_ || !prediction_->views) return std::nullopt;
  return static_cast<double>(views_.size()) + (1 - map_->CoveredShare()) * *prediction_->views;
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

  state->subject = summary_.subject;
  state->rectangle_share = options_.limits.rectangle_share;
  state->coverage = map_;
  state->view_ids = views_.Ids();
  if (options_.cap) state->covered = map_ ? map_->CoveredShare() : 0;
  state->reopened = reopened_.directions();
  state->prediction = prediction_;
  state->views_expected = ViewsExpected();
  state->guidance = looked_.guidance;
  state->subject_moved = subject_moved_;

  state->decision = looked_.decision;
  state->recording = recording_;
  state->recorded_view = looked_.recorded_view;
  state->device_problem = DeviceProblem();
  if (!state->device_problem.empty())
    state->waiting_for = "the device, " + state->device_problem;
  else
    state->waiting_for = gaps_.DiskReason();
  state->exposure_locked = device_.Held().exposure;
  state->preflight = preflight_;
  state->said = said_;
  return state;
}

// False when it has to be tried again: the disk is behind.
bool Session::CorrectPoses(bool last) {
  if (views_.empty()) return true;
  const std::map<int, Rigid3> now = views_.PosesNow(poses_);
  const double largest_move = views_.LargestMove(now, map_ ? &map_->subject() : nullptr);
  constexpr double kWorthPaintingAnew = 2e-4;  // radians: about a tenth of a pixel
  if (largest_move <= 0 || (!last && largest_move < kWorthPaintingAnew)) return true;
  if (!last && !spool_.TryUpdatePoses(now)) return false;
  views_.MoveTo(now);
  const double fell_open = Repaint();
  constexpr double kWorthAWord = 0.005;
  if (fell_open >= kWorthAWord)
    Say(fmt::format("poses were corrected: {:.1f} % {} fell open again", 100 * fell_open, OfWhat()));
  return true;
}

// The map says when it is worth measuring; the measure, on directions of its own, decides.
bool Session::CapIsCovered() {
  if (!options_.cap || !map_ || measured_ || map_->CoveredShare() < options_.until_share) return false;
  measured_ = true;
  CorrectPoses(false);
  return MeasureCoverage(map_->views(), map_->subject(), *options_.cap, map_->options()).covered >=
         options_.until_share;
}

std::optional<StoppedBecause> Session::Enough() const {
  if (hooks_.stop_requested && hooks_.stop_requested()) return StoppedBecause::kSignal;
  if (finish_asked_) return StoppedBecause::kClosed;
  if (spool_.Failure()) return StoppedBecause::kDisk;
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
    if (hooks_.while_waiting) hooks_.while_waiting(State());
    if (device_.State() == DeviceState::kEnded) return StoppedBecause::kEnded;
    if (device_.State() == DeviceState::kLost) return StoppedBecause::kDeviceLost;
    return std::nullopt;
  }
  looked_.recorded_view.reset();
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
  PlaceFirstSubject(track);
  SayWhatToExpect();
  CheckBeforeFirstView(*frame);
  WatchSubject(track);
  looked_.decision = DecideAndRecord(*frame, track);
  gaps_.Disk(spool_.Pause(), *last_time_s_);
  // A closed loop moves views at once by what drift had come to.
  poses_due_ |= std::exchange(map_revision_, track.map_revision) != track.map_revision ||
                summary_.frames % static_cast<std::uint64_t>(options_.frames_between_pose_updates) == 0;
  if (poses_due_) poses_due_ = !CorrectPoses(false);
  if (hooks_.after_frame) {
    std::optional<CriterionView> here;
    if (track.cam_from_world)
      here = CriterionView::From(recorded_camera_, *track.cam_from_world, options_.coverage_width_px);
    looked_.guidance = guide_.After(map_.get(), here, *last_time_s_);
    hooks_.after_frame(State());
  }
  if (looked_.decision.reason == Reason::kRecorded && CapIsCovered()) return StoppedBecause::kCovered;
  return std::nullopt;
}

void Session::CloseLightField(LightFieldWriter& writer) {
  std::map<int, Rigid3> final_poses;
  for (const HeldView& held : views_.views()) final_poses[held.id] = held.cam_from_world;
  for (const View& view : writer.Contents().views)
    if (const auto found = final_poses.find(view.id);
        found != final_poses.end() && Same(view.cam_from_world, found->second))
      final_poses.erase(found);
  std::map<std::string, std::uint64_t> reasons = earlier_reasons_;
  for (const Reason reason : kReasons)
    reasons[Name(reason)] += summary_.reasons[static_cast<std::size_t>(reason)];
  const double device_s = first_time_s_ ? *last_time_s_ - *first_time_s_ : 0;
  const double capture_s = device_s > 0 ? device_s : ended_after_s_;
  try {
    writer.UpdatePoses(final_poses);
    if (auto points = poses_.Points(); !points.empty()) writer.SetPoints(std::move(points));
    writer.Close(earlier_s_ + capture_s, reasons);
  } catch (const std::exception& error) {
    summary_.stopped_because = StoppedBecause::kDisk;
    summary_.problem = error.what();
  }
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
  CorrectPoses(true);
  gaps_.End(last_time_s_);
  summary_.pauses = gaps_.pauses();
  summary_.paused_s = gaps_.paused_s();
  if (const std::size_t following = spool_.PicturesWaiting(); following > 10)
    Say(fmt::format("everything recorded is on disk; {} photographs of images/ are being made", following));
  LightFieldWriter writer = spool_.Finish();
  summary_.unwritten = spool_.Unwritten();
  summary_.set_aside = spool_.SetAside();
  for (const View& view : writer.Contents().views) summary_.recorded += view.id >= first_new_id_;
  if (stills_) summary_.stills.recorded = summary_.recorded;
  if (const auto failure = spool_.Failure()) {
    summary_.stopped_because = StoppedBecause::kDisk;
    summary_.problem = *failure;
  } else {
    CloseLightField(writer);
  }
}

CaptureSummary Session::Run() {
  if (const auto subject = options_.subject ? options_.subject : resumed_subject_) SetSubject(*subject);
  const auto started = Clock::now();
  std::optional<StoppedBecause> why;
  std::exception_ptr failure;
  try {
    while (!why) {
      AnswerRequests();
      why = Enough();
      if (!why) why = TakeFrame();
    }
  } catch (...) {
    failure = std::current_exception();  // whatever broke: what was recorded is closed first
    why = StoppedBecause::kDeviceLost;
  }
  ended_after_s_ = options_.deterministic ? 0 : MillisecondsSince(started) / 1000;
  try {
    device_.Stop();
    // Photographs that were on their way, or came before the end was asked for.
    for (const Frame& frame : std::exchange(first_, {}))
      if (frame.kind == FrameKind::kStill) TakeStill(frame);
    while (const auto frame = stills_ ? device_.Next(std::chrono::milliseconds(0)) : std::nullopt)
      if (frame->kind == FrameKind::kStill) TakeStill(*frame);
  } catch (...) {
    if (!failure) failure = std::current_exception();
  }
  if (stills_) summary_.stills = stills_->counts();
  summary_.stopped_because = *why;
  Close();
  if (failure) std::rethrow_exception(failure);
  summary_.device = device_.Statistics();
  summary_.ms_track_median = Median(ms_track_);
  summary_.ms_decide_median = Median(ms_decide_);
  summary_.map = std::move(map_);
  return std::move(summary_);
}

}  // namespace

const char* Name(StoppedBecause why) {
  constexpr std::array kNames{"covered", "frames",      "seconds", "ended",
                              "signal",  "device_lost", "disk",    "closed"};
  return kNames[static_cast<std::size_t>(why)];
}

CaptureSummary RunCapture(Device& device, const CameraModel& camera, PoseSource& poses,
                          LightFieldWriter writer, const CaptureOptions& options, const CaptureHooks& hooks,
                          std::vector<Frame> first) {
  return Session(device, camera, poses, std::move(writer), options, hooks, std::move(first)).Run();
}

}  // namespace ulf
