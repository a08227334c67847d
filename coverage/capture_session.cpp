#include "coverage/capture_session.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <deque>
#include <exception>
#include <iterator>
#include <utility>

#include "coverage/sphere_outline.h"
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

// The mean depth of the tracked points near the image centre; the nearest and farthest quarter may belong to
// what stands before or behind the subject.
std::optional<double> DepthNearCenter(const std::vector<VisiblePoint>& points, const CameraModel& camera) {
  constexpr double kReach = 0.25;  // of the image's height
  constexpr std::size_t kFewest = 8;
  const Eigen::Vector2d middle(0.5 * camera.width, 0.5 * camera.height);
  std::vector<double> depths;
  for (const VisiblePoint& point : points)
    if ((point.img - middle).norm() < kReach * camera.height && point.depth > 0)
      depths.push_back(point.depth);
  if (depths.size() < kFewest) return std::nullopt;
  std::sort(depths.begin(), depths.end());
  const std::size_t from = depths.size() / 4, to = depths.size() - from;
  double sum = 0;
  for (std::size_t i = from; i < to; ++i) sum += depths[i];
  return sum / static_cast<double>(to - from);
}

bool Same(const Rigid3& a, const Rigid3& b) {
  return a.rotation.coeffs() == b.rotation.coeffs() && a.translation == b.translation;
}

// A recorded view's pose: its anchor's, or fixed where it was recorded in an earlier session.
struct ViewPose {
  std::optional<Anchored> anchor;
  Rigid3 cam_from_world;
};

// Time in which nothing was recorded, since `from_s` of the device's time.
struct OpenGap {
  double from_s = 0;
  std::string reason;
  Clock::time_point began = Clock::now();
  bool said = false;

  double HostSeconds() const { return MillisecondsSince(began) / 1000; }
};

// A slow disk catches up within moments: not worth a word.
constexpr double kShortestPause_s = 0.5;

class Session {
 public:
  Session(Device& device, const CameraModel& camera, PoseSource& poses, LightFieldWriter writer,
          const CaptureOptions& options, const CaptureHooks& hooks, std::vector<Frame> first);
  CaptureSummary Run();

 private:
  std::optional<StoppedBecause> Enough() const;
  std::optional<Frame> NextFrame();
  std::optional<StoppedBecause> TakeFrame();
  void PlaceSubject(const Track& track);
  void SetSubject(const Subject& subject);
  Decision DecideAndRecord(const Frame& frame, const Track& track);
  bool Record(const Frame& frame, const Track& track, const Decision& decision);
  std::optional<StoppedBecause> TakeStill(const Frame& still);
  void NoteGaps(const Frame& frame, const Track& track);
  void TakeEvents();
  void NoteDeviceGap(double to_s);
  void NotePause(double now_s);
  void EndPause(double now_s, bool ended = false);
  void Say(const std::string& text) const;
  CaptureProgress Progress(Reason reason) const;
  bool CorrectPoses(bool last);
  bool CapIsCovered();
  std::vector<CriterionView> ViewsForCriterion() const;
  void Close();

  Device& device_;
  const CameraModel camera_;  // of the frames that are tracked
  PoseSource& poses_;
  const CaptureOptions options_;
  const CameraModel recorded_camera_;
  std::optional<StillCapture> stills_;
  const CaptureHooks& hooks_;
  std::deque<Frame> first_;  // before the device is asked
  const std::size_t earlier_views_;
  const double earlier_s_;
  const std::map<std::string, std::uint64_t> earlier_reasons_;
  std::optional<Subject> resumed_subject_;
  std::vector<ViewPose> view_poses_;
  ViewSpool spool_;

  std::unique_ptr<CoverageMap> map_;
  CaptureSummary summary_;
  std::vector<double> ms_track_, ms_decide_;
  int tracked_in_a_row_ = 0;
  std::optional<double> first_time_s_, last_time_s_, lost_since_s_;
  std::optional<OpenGap> device_gap_, pause_;
  double frame_period_s_ = 0;
  bool tracked_before_ = false;
  int map_revision_ = 0;  // of the tracker, as last seen
  bool poses_due_ = false;
  std::size_t views_at_last_measure_ = 0;
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
      earlier_views_(writer.Contents().views.size()),
      earlier_s_(writer.Contents().capture_s),
      earlier_reasons_(writer.Contents().reasons),
      resumed_subject_(writer.Contents().subject),
      view_poses_([&] {
        std::vector<ViewPose> views;
        for (const View& view : writer.Contents().views) views.push_back({{}, view.cam_from_world});
        return views;
      }()),
      spool_(std::move(writer), options.spool_views, !options.deterministic) {
  if (options.still_camera)
    stills_.emplace(device_, *options.still_camera, poses_, options_.limits, options_.coverage_width_px);
}

std::vector<CriterionView> Session::ViewsForCriterion() const {
  std::vector<CriterionView> views;
  for (const ViewPose& view : view_poses_)
    views.push_back(CriterionView::From(recorded_camera_, view.cam_from_world, options_.coverage_width_px));
  return views;
}

void Session::SetSubject(const Subject& subject) {
  summary_.subject = subject;
  if (resumed_subject_ != subject) spool_.SetSubject(subject);
  map_ = std::make_unique<CoverageMap>(
      subject, CoverageMapOptions{.cap = options_.cap, .threshold_px = options_.threshold_px});
  map_->SetViews(ViewsForCriterion());
}

void Session::PlaceSubject(const Track& track) {
  tracked_in_a_row_ = track.state == TrackState::kTracking ? tracked_in_a_row_ + 1 : 0;
  if (map_ || tracked_in_a_row_ < options_.stable_frames || !track.cam_from_world) return;
  if (const auto depth = DepthNearCenter(poses_.VisiblePoints(), camera_))
    SetSubject(SubjectOnAxis(camera_, *track.cam_from_world, *depth, options_.subject_size));
}

bool Session::Record(const Frame& frame, const Track& track, const Decision& decision) {
  Frame kept = frame;  // its pixels are shared: no device writes into them again
  if (options_.deterministic) kept.host_time_s = kept.device_time_s;
  View view;
  view.cam_from_world = *track.cam_from_world;
  view.tracking_quality = track.quality;
  view.bound_px = decision.bound_px;
  if (frame.kind == FrameKind::kStill)
    spool_.AddView(kept, view);
  else if (!spool_.TryAddView(kept, view))
    return false;
  view_poses_.push_back({track.anchor, view.cam_from_world});
  map_->Add(CriterionView::From(recorded_camera_, view.cam_from_world, options_.coverage_width_px));
  summary_.last_recorded = RecordedFrame{std::move(kept), view.cam_from_world};
  return true;
}

Decision Session::DecideAndRecord(const Frame& frame, const Track& track) {
  const auto start = Clock::now();
  Decision decision = Decide({.frame = frame,
                              .track = track,
                              .camera = camera_,
                              .frame_period_s = frame_period_s_,
                              .coverage_width_px = options_.coverage_width_px},
                             map_.get(), options_.limits);
  ms_decide_.push_back(MillisecondsSince(start));
  if (stills_) {
    stills_->Follow(frame, track);
    if (decision.reason == Reason::kRecorded) {
      decision.reason = spool_.Pause() ? Reason::kSpool : Reason::kStill;
      if (decision.reason == Reason::kStill) stills_->Ask();
    }
  } else if (decision.reason == Reason::kRecorded && !Record(frame, track, decision)) {
    decision.reason = Reason::kSpool;
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

// Time without a pose is written down, so that a review can show it.
void Session::NoteGaps(const Frame& frame, const Track& track) {
  constexpr double kShortestGapS = 0.5;
  const bool tracked = track.state == TrackState::kTracking;
  tracked_before_ |= tracked;
  if (!tracked && tracked_before_ && !lost_since_s_) lost_since_s_ = frame.device_time_s;
  if (!tracked || !lost_since_s_) return;
  if (frame.device_time_s - *lost_since_s_ >= kShortestGapS)
    spool_.NoteGap(*lost_since_s_, frame.device_time_s, Name(Reason::kTracking));
  lost_since_s_.reset();
}

void Session::Say(const std::string& text) const {
  if (hooks_.say) hooks_.say(text);
}

void Session::TakeEvents() {
  for (const DeviceEvent& event : device_.TakeEvents()) {
    ++summary_.events[Name(event.kind)];
    Say(event.text);
    if (event.kind == DeviceEventKind::kFaulted && last_time_s_ && !device_gap_)
      device_gap_ = OpenGap{*last_time_s_, "device: " + event.text};
  }
}

void Session::NoteDeviceGap(double to_s) {
  if (!device_gap_) return;
  spool_.NoteGap(device_gap_->from_s, to_s, device_gap_->reason);
  device_gap_.reset();
}

void Session::NotePause(double now_s) {
  const auto why = spool_.Pause();
  if (!why) return EndPause(now_s);
  if (!pause_) pause_ = OpenGap{now_s, *why};
  if (pause_->said || now_s - pause_->from_s < kShortestPause_s) return;
  pause_->said = true;
  Say("recording waits, tracking goes on: " + *why);
}

void Session::EndPause(double now_s, bool ended) {
  if (!pause_) return;
  const double length_s = now_s - pause_->from_s;
  if (length_s >= kShortestPause_s) {
    ++summary_.pauses;
    summary_.paused_s += length_s;
    spool_.NoteGap(pause_->from_s, now_s, "recording paused: " + pause_->reason);
    if (pause_->said)
      Say(ended ? fmt::format("recording was still waiting, since {:.1f} s, when the capture ended", length_s)
                : fmt::format("recording goes on after {:.1f} s", length_s));
  }
  pause_.reset();
}

CaptureProgress Session::Progress(Reason reason) const {
  CaptureProgress progress{
      .frames = summary_.frames,
      .views = view_poses_.size(),
      .covered = options_.cap ? std::optional<double>(map_ ? map_->CoveredShare() : 0) : std::nullopt,
      .reason = reason,
      .device_time_s = last_time_s_.value_or(0),
      .cam_from_world = {},
      .waiting_for = {}};
  const DeviceState state = device_.State();
  if (state == DeviceState::kFaulted || state == DeviceState::kReconnecting)
    progress.waiting_for = fmt::format("the device ({}): {}", Name(state), device_.Info().problem);
  else if (pause_)
    progress.waiting_for = pause_->reason;
  return progress;
}

// False when it has to be tried again: the disk is behind.
bool Session::CorrectPoses(bool last) {
  if (view_poses_.empty()) return true;
  std::vector<Rigid3> corrected;
  double largest_move = 0;
  for (const ViewPose& view : view_poses_) {
    corrected.push_back(view.anchor ? poses_.PoseOf(*view.anchor) : view.cam_from_world);
    const Rigid3 moved = corrected.back() * view.cam_from_world.Inverse();
    // Against the distance to the subject both are angles.
    const double distance = map_ ? (view.cam_from_world * map_->subject().center_in_world).norm() : 1;
    largest_move =
        std::max({largest_move, RotationAngle(moved.rotation), moved.translation.norm() / distance});
  }
  constexpr double kWorthPaintingAnew = 2e-4;  // radians: about a tenth of a pixel
  if (largest_move <= 0 || (!last && largest_move < kWorthPaintingAnew)) return true;
  if (!last && !spool_.TryUpdatePoses(corrected)) return false;
  for (std::size_t i = 0; i < corrected.size(); ++i) view_poses_[i].cam_from_world = corrected[i];
  if (map_) map_->SetViews(ViewsForCriterion());
  return true;
}

// The map says when it is worth measuring; the measure, on directions of its own, decides.
bool Session::CapIsCovered() {
  if (!options_.cap || !map_ || map_->CoveredShare() < options_.until_share) return false;
  if (view_poses_.size() == views_at_last_measure_) return false;
  views_at_last_measure_ = view_poses_.size();
  CorrectPoses(false);
  return MeasureCoverage(map_->views(), map_->subject(), *options_.cap, map_->options()).covered >=
         options_.until_share;
}

std::optional<StoppedBecause> Session::Enough() const {
  if (hooks_.stop_requested && hooks_.stop_requested()) return StoppedBecause::kSignal;
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

std::optional<StoppedBecause> Session::TakeFrame() {
  const std::optional<Frame> frame = NextFrame();
  TakeEvents();
  if (!frame) {
    if (hooks_.while_waiting) hooks_.while_waiting(Progress(Reason::kTracking));
    if (device_.State() == DeviceState::kEnded) return StoppedBecause::kEnded;
    if (device_.State() == DeviceState::kLost) return StoppedBecause::kDeviceLost;
    return std::nullopt;
  }
  if (frame->kind == FrameKind::kStill) return TakeStill(*frame);
  if (frame->status != FrameStatus::kComplete) return std::nullopt;  // the device counts them
  ++summary_.frames;
  if (hooks_.keep_frame) hooks_.keep_frame(*frame);
  if (last_time_s_) {
    // The shortest recent time between frames: a dropped one must not look like a slow camera.
    const double step_s = frame->device_time_s - *last_time_s_;
    // A camera may stop for seconds and go on by itself: no fault to its driver, a gap all the same.
    if (device_.IsLive() && !device_gap_ && frame_period_s_ > 0 &&
        step_s > std::max(kShortestPause_s, 10 * frame_period_s_))
      device_gap_ = OpenGap{*last_time_s_, "device: no frames"};
    if (step_s > 0) frame_period_s_ = frame_period_s_ > 0 ? std::min(step_s, 1.1 * frame_period_s_) : step_s;
  }
  last_time_s_ = frame->device_time_s;
  NoteDeviceGap(*last_time_s_);
  if (!first_time_s_) first_time_s_ = last_time_s_;

  const auto start = Clock::now();
  const Track track = poses_.Step(*frame);
  ms_track_.push_back(MillisecondsSince(start));
  NoteGaps(*frame, track);
  PlaceSubject(track);
  const Decision decision = DecideAndRecord(*frame, track);
  NotePause(*last_time_s_);
  // A closed loop moves views at once by what drift had come to.
  poses_due_ |= std::exchange(map_revision_, track.map_revision) != track.map_revision ||
                summary_.frames % static_cast<std::uint64_t>(options_.frames_between_pose_updates) == 0;
  if (poses_due_) poses_due_ = !CorrectPoses(false);
  if (hooks_.after_frame) {
    CaptureProgress progress = Progress(decision.reason);
    progress.cam_from_world = track.cam_from_world;
    if (track.state != TrackState::kTracking && progress.waiting_for.empty())
      progress.waiting_for = InWords(track);
    hooks_.after_frame(progress);
  }
  if (decision.reason == Reason::kRecorded && CapIsCovered()) return StoppedBecause::kCovered;
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
  CorrectPoses(true);
  if (device_gap_) NoteDeviceGap(device_gap_->from_s + device_gap_->HostSeconds());
  if (last_time_s_) EndPause(*last_time_s_, true);
  if (const std::size_t following = spool_.PicturesWaiting(); following > 10 && hooks_.say)
    hooks_.say(
        fmt::format("everything recorded is on disk; {} photographs of images/ are being made", following));
  LightFieldWriter writer = spool_.Finish();
  summary_.unwritten = spool_.Unwritten();
  summary_.set_aside = spool_.SetAside();
  summary_.recorded = writer.Contents().views.size() - earlier_views_;
  if (stills_) summary_.stills.recorded = summary_.recorded;
  if (const auto failure = spool_.Failure()) {
    summary_.stopped_because = StoppedBecause::kDisk;
    summary_.problem = *failure;
  } else {
    std::map<int, Rigid3> final_poses;
    for (std::size_t i = 0; i < view_poses_.size(); ++i)
      if (!Same(writer.Contents().views[i].cam_from_world, view_poses_[i].cam_from_world))
        final_poses[writer.Contents().views[i].id] = view_poses_[i].cam_from_world;
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
}

CaptureSummary Session::Run() {
  if (const auto subject = options_.subject ? options_.subject : resumed_subject_) SetSubject(*subject);
  const auto started = Clock::now();
  std::optional<StoppedBecause> why;
  std::exception_ptr failure;
  try {
    while (!why) {
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
  constexpr std::array kNames{"covered", "frames", "seconds", "ended", "signal", "device_lost", "disk"};
  return kNames[static_cast<std::size_t>(why)];
}

CaptureSummary RunCapture(Device& device, const CameraModel& camera, PoseSource& poses,
                          LightFieldWriter writer, const CaptureOptions& options, const CaptureHooks& hooks,
                          std::vector<Frame> first) {
  return Session(device, camera, poses, std::move(writer), options, hooks, std::move(first)).Run();
}

}  // namespace ulf
