#include "coverage/session/running_capture.h"

#include <fmt/format.h>

#include <iterator>
#include <utility>

#include "core/base/counted.h"
#include "core/base/host_time.h"
#include "tracking/tracker/track.h"

namespace ulf::coverage {

RunningCapture::RunningCapture(acquisition::Device& device, const CameraModel& camera,
                               tracking::PoseSource& poses, LightFieldWriter writer, ExposureMatch light,
                               const CaptureOptions& options, const CaptureHooks& hooks,
                               std::vector<Frame> first)
    : device_(device),
      poses_(poses),
      options_(options),
      lens_(camera, options.still_camera),
      hooks_(hooks),
      first_(std::make_move_iterator(first.begin()), std::make_move_iterator(first.end())),
      root_(writer.Contents().root),
      record_(std::move(writer), lens_, options_, say_, source_),
      reporter_(say_),
      subject_(record_, reporter_, poses_, lens_, options_, source_, say_),
      gaps_(record_.spool(), say_),
      recorder_(device_, poses_, lens_, record_, std::move(light), options_, say_),
      proposer_(lens_, options_) {
  if (options.turntable) turntable_.emplace(options.turntable->Text(), source_);
}

void RunningCapture::AnnouncePrediction() {
  if (!record_.map() || !reporter_.IsDue() || !latest_.track.cam_from_world) return;
  const Subject& subject = record_.map()->subject();
  const double distance = (*latest_.track.cam_from_world * subject.center_in_world).norm();
  reporter_.Expect(
      SetupAt(lens_.recorded(), options_.coverage_width_px, subject, distance, options_.threshold_px),
      options_.cap, options_.until_share, poses_.IsMetric(), source_);
}

// Runs before anything else uses a frame: poses under another lens must not mix with poses under this one.
void RunningCapture::FollowLens(const tracking::Track& track) {
  if (const auto before = lens_.Update(track, poses_)) ReplaceLens(*before, false);
  // What is replaced before the next frame needs no warning.
  if (!lens_.contradicted() || lens_doubted_ || options_.LensMayChange()) return;
  lens_doubted_ = true;
  Say(lens_.contradicted()->Advice(source_));
}

void RunningCapture::ReplaceLens(const CameraModel& before, bool last) {
  const auto covered = [this] { return record_.map() && options_.cap ? record_.map()->CoveredShare() : 0; };
  const double covered_before = covered();
  record_.ReplaceLens(before, poses_, last, subject_.UnderNewLens(before));
  reporter_.Reset();
  const tracking::RefinedLens& found = *lens_.found();
  const std::size_t views = record_.views().size();
  // The second time it is the same lens, known a little better.
  const bool differs = std::abs(found.camera.MeanFocalPx() - before.MeanFocalPx()) > found.focal_sigma_px;
  std::string followed = "; nothing was recorded yet";
  if (views > 0)
    followed = fmt::format(", and {} so far {} with it: lens, poses and what is covered",
                           Counted(views, "view"), views == 1 ? "goes" : "go");
  if (views > 0 && options_.cap)
    followed += fmt::format(" ({:.1f} %, before it was {:.1f} %)", 100 * covered(), 100 * covered_before);
  Say(fmt::format("images fit {}{}: the capture {} this lens{}", found.Text(),
                  differs ? fmt::format(", not the {:.1f} px in use", before.MeanFocalPx()) : "",
                  last ? "ends under" : "goes on under", followed));
}

void RunningCapture::NoteZoom(const tracking::Track& track) {
  if (track.state != tracking::TrackState::kTracking || track.focal_ratio.has_value() == zoom_moved_) return;
  zoom_moved_ = track.focal_ratio.has_value();
  Say(zoom_moved_ ? tracking::ZoomInWords(*track.focal_ratio, source_) + "; nothing is recorded meanwhile"
                  : "the zoom is back");
}

// Before the first view the preflight says what was noticed, but for what the lens and the shutter are.
void RunningCapture::LookForMistakes(const Frame& frame) {
  if (frame.asked_stops) return;  // another exposure on purpose
  picture_ =
      light_and_focus_.Update(frame.device_time_s, frame.image, lens_.live(), latest_.track.cam_from_world,
                              subject_.IsPlaced() ? record_.subject() : std::nullopt);
  MistakeSigns signs{.held = device_.Held(),
                     .fine_detail = picture_.fine_detail,
                     .badly_exposed = picture_.light && IsBadlyExposed(*picture_.light),
                     .subject_turns = options_.turntable.has_value()};
  // Another lens takes the contradicted one's place.
  if (!options_.LensMayChange()) signs.lens_contradicted = lens_.contradicted();
  constexpr double kAsksEvery_s = 1;  // all of the tracker's statistics are made for it
  if (!shutter_asked_s_ || std::abs(frame.device_time_s - *shutter_asked_s_) >= kAsksEvery_s) {
    shutter_asked_s_ = frame.device_time_s;
    signs.rolling_shutter = poses_.Statistics().rolling_shutter;
  }
  for (const NoticedMistake& noticed : mistakes_.Update(frame, signs)) {
    const bool said_elsewhere = noticed.mistake == Mistake::kWrongLens ||
                                (noticed.mistake != Mistake::kRollingShutter && AwaitsFirstView());
    if (!said_elsewhere) Say(noticed.InWords());
  }
}

void RunningCapture::UpdatePreflight(const Frame& frame) {
  if (!AwaitsFirstView()) return;
  const auto pixels = [](const CameraModel& camera) {
    return static_cast<double>(camera.width) * static_cast<double>(camera.height);
  };
  const double view_per_frame = pixels(lens_.recorded()) / pixels(lens_.live());
  reporter_.Check({.source = source_,
                   .resumed = !record_.views().empty(),
                   .calibrated = options_.calibrated,
                   .calibration_source = options_.calibration_source,
                   .lens_is_sought = options_.LensMayChange(),
                   .lens_found = lens_.found(),
                   .lens_contradicted = lens_.contradicted(),
                   .held = device_.Held(),
                   .picture = picture_,
                   .prediction = {},
                   .cap = options_.cap,
                   .without_subject = options_.without_subject.has_value(),
                   .bytes_per_view = static_cast<std::uint64_t>(
                       view_per_frame * static_cast<double>(ViewSpool::MostBytes(frame))),
                   .disk_left_bytes = meters_.DiskLeftBytes(root_),
                   .link = meters_.Link(device_),
                   .mistakes = mistakes_.noticed(),
                   .has_pose = latest_.track.cam_from_world.has_value(),
                   .tracking_words = tracking::InWords(latest_.track, source_),
                   .pose_error_px = PoseErrorNow()});
}

std::optional<double> RunningCapture::PoseErrorNow() const {
  const tracking::Track& track = latest_.track;
  const auto sigma = track.PictureSigma();
  if (!record_.map() || !track.cam_from_world || !sigma) return std::nullopt;
  const Subject& subject = record_.map()->subject();
  return PoseErrorPx(*sigma, CriterionView::From(lens_.recorded(), {}, options_.coverage_width_px).fx,
                     (*track.cam_from_world * subject.center_in_world).norm(), subject.radius);
}

// Without a pose while the subject's sphere stands in a map that is gone: where the camera stands about it is
// not known.
tracking::Track RunningCapture::TrackToRecord(const tracking::Track& track) const {
  tracking::Track usable = track;
  if (subject_.IsStale()) usable.cam_from_world.reset();
  return usable;
}

void RunningCapture::UpdateCapWatch(const tracking::Track& track, const Decision& decision) {
  if (!record_.map() || !track.cam_from_world) return;
  const bool would_record = decision.reason == Reason::kCovered || decision.reason == Reason::kRecorded;
  const auto report = cap_watch_.Update(*record_.map(), track.cam_from_world->OriginInSource(),
                                        would_record && recorder_.IsRecording());
  if (report) Say(*report);
}

void RunningCapture::Say(const std::string& text) {
  constexpr std::size_t kLinesShown = 3;  // as many as a person can read at once
  said_.push_back(text);
  if (said_.size() > kLinesShown) said_.erase(said_.begin());
  ++times_said_;
  if (hooks_.say) hooks_.say(text);
}

void RunningCapture::TakeEvents() {
  const std::vector<acquisition::DeviceEvent> events = device_.TakeEvents();
  for (const std::string& line : repeated_.Update(events, EpochSeconds())) Say(line);
  for (const acquisition::DeviceEvent& event : events) {
    ++summary_.events[Name(event.kind)];
    if (event.kind == acquisition::DeviceEventKind::kFaulted && meters_.last_time_s())
      gaps_.DeviceFaulted(*meters_.last_time_s(), event.text);
  }
}

// Returns false when the disk is behind.
bool RunningCapture::CorrectPoses(bool last) {
  const std::optional<Subject> before = record_.subject(), followed = subject_.Followed();
  if (!record_.CorrectPoses(poses_, last, followed)) return false;
  if (followed) subject_.SayFollowed(*before);
  return true;
}

void RunningCapture::ProposeSubject() {
  if (!record_.map() || !latest_.track.cam_from_world) return;
  const Subject& subject = *record_.subject();
  const double distance = (*latest_.track.cam_from_world * subject.center_in_world).norm();
  if (const auto proposal = proposer_.Update(record_.mesh(), subject, distance))
    Say(InWords(*proposal, subject));
}

std::string RunningCapture::DeviceProblem() const {
  const acquisition::DeviceState state = device_.State();
  if (state != acquisition::DeviceState::kFaulted && state != acquisition::DeviceState::kReconnecting)
    return {};
  return fmt::format("{}: {}", Name(state), device_.Info().problem);
}

void RunningCapture::DescribeRecord(CaptureState& state) const {
  if (subject_.IsPlaced()) {
    state.subject = record_.subject();
    state.coverage = record_.map();
  }
  state.recorded_camera_index = record_.camera_index();
  state.view_ids = record_.views().Ids();
  if (options_.cap) state.covered = record_.map() ? record_.map()->CoveredShare() : 0;
  for (const ReopenedDirection& reopened : record_.reopened()) {
    state.reopened.push_back(reopened.direction);
    state.reopened_share += reopened.share;
  }
  if (record_.errors() && !record_.errors()->empty()) state.errors = record_.errors();
  state.cover = options_.cover;
  state.mesh = record_.mesh();
  state.mesh_may_come = record_.MeshMayCome();
  state.errors_may_come = record_.ErrorsMayCome();
}

SharedCaptureState RunningCapture::State() {
  auto state = std::make_shared<CaptureState>();
  state->source = source_;
  state->metric = poses_.IsMetric();
  state->frames = summary_.frames;
  state->device_time_s = meters_.last_time_s().value_or(0);
  state->frames_per_s = meters_.FramesPerS();
  state->dropped = meters_.Dropped(device_);
  state->disk_left_bytes = meters_.DiskLeftBytes(root_);

  const tracking::Track& track = latest_.track;
  state->live = latest_.live;
  state->camera = lens_.live();
  state->recorded_camera = lens_.recorded();
  state->takes_stills = options_.still_camera.has_value();
  state->tracking = track.state;
  if (track.turn && !IsTaken(source_))
    state->turned =
        CameraTurn{last_turn_ ? *track.turn * last_turn_->conjugate() : *track.turn, last_turn_.has_value()};
  if (track.state != tracking::TrackState::kTracking)
    state->tracking_words = InWords(track, state->turned, source_);
  state->cam_from_world = track.cam_from_world;
  state->start = track.start;
  if (track.cam_from_world) state->points = poses_.VisiblePoints();

  if (options_.turntable) state->table_up_in_world = -Eigen::Vector3d::UnitZ();  // of the board's frame
  state->without_subject = options_.without_subject.has_value();
  state->finding_subject = subject_.Finding();
  DescribeRecord(*state);
  state->prediction = reporter_.prediction();
  state->preflight = reporter_.preflight();
  state->views_expected = reporter_.ViewsExpected(state->view_ids.size(), state->coverage.get());
  state->mistakes = mistakes_.noticed();
  state->seconds = meters_.DeviceSeconds();
  if (proposer_.proposal()) state->proposed_subject = proposer_.proposal()->subject;
  state->newest_view = recorder_.newest_view();
  state->light_field = root_;
  state->guidance = latest_.guidance;
  state->subject_moved = subject_.Moved();

  state->decision = latest_.decision;
  state->recording = recorder_.IsRecording();
  state->waits_to_begin = waits_to_begin_;
  state->recorded_view = recorder_.newest_id();
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

void RunningCapture::Show(const std::function<void(const SharedCaptureState&)>& look) {
  if (!look) return;
  look(State());
  recorder_.ForgetNewestId();
}

}  // namespace ulf::coverage
