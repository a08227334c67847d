// Runs the loop of a capture. The class is private to RunCapture() (capture_session.h); it has three sources:
// capture_session.cpp takes the frames, running_capture.cpp does what follows tracking and makes the state,
// capture_answers.cpp answers requests.
#pragma once

#include <cstdint>
#include <deque>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/device/repeated_events.h"
#include "core/light_field/folder/light_field_writer.h"
#include "coverage/bound/guidance.h"
#include "coverage/session/cap_watch.h"
#include "coverage/session/capture_gaps.h"
#include "coverage/session/capture_meters.h"
#include "coverage/session/capture_state.h"
#include "coverage/session/capture_subject.h"
#include "coverage/session/capture_summary.h"
#include "coverage/session/light_and_focus.h"
#include "coverage/session/preflight.h"
#include "coverage/session/record/capture_lens.h"
#include "coverage/session/record/capture_record.h"
#include "coverage/session/record/capture_recorder.h"
#include "coverage/session/subject_proposal.h"
#include "coverage/session/turntable_watch.h"

namespace ulf::coverage {

class RunningCapture {
 public:
  // As RunCapture(); `light` knows the views of earlier sessions, `device`, `poses` and `hooks` outlive it.
  RunningCapture(acquisition::Device& device, const CameraModel& camera, tracking::PoseSource& poses,
                 LightFieldWriter writer, ExposureMatch light, const CaptureOptions& options,
                 const CaptureHooks& hooks, std::vector<Frame> first);
  CaptureSummary Run();

 private:
  // The latest frame about which a decision was made, and the decision.
  struct LatestFrame {
    Image live;
    tracking::Track track;
    Decision decision;
    Guidance guidance;
  };
  std::optional<StoppedBecause> StopReason() const;
  std::optional<Frame> NextFrame();
  std::optional<StoppedBecause> TakeFrame();
  std::optional<StoppedBecause> TakeStill(const Frame& still);
  void UpdateCapWatch(const tracking::Track& track, const Decision& decision);

  void AnnouncePrediction();
  void FollowLens(const tracking::Track& track);
  void ReplaceLens(const CameraModel& before, bool last);
  void NoteZoom(const tracking::Track& track);
  // A resumed session, too, awaits a first view of its own.
  bool AwaitsFirstView() const { return record_.views().empty() || !recorder_.newest_view(); }
  void UpdatePreflight(const Frame& frame);
  void LookForMistakes(const Frame& frame);
  std::optional<double> PoseErrorNow() const;
  tracking::Track TrackToRecord(const tracking::Track& track) const;
  bool CorrectPoses(bool last);
  void ProposeSubject();
  void BeginWhenPossible();
  void Begin(bool although_checks_fail);

  void AnswerRequests();
  void Answer(const TakeBackLast& asked);
  void Answer(const TakeBackViews& asked);
  void Answer(const PlaceSphere& asked);
  void Answer(const FindSubject& asked);
  void Answer(const PlaceProposedSphere& asked);
  void Answer(const SetRecording& asked);
  void Answer(const FinishCapture& asked);

  void TakeEvents();
  void Say(const std::string& text);
  void SayClosing(const std::string& step) const {
    if (hooks_.closing) hooks_.closing(step);
  }
  std::string DeviceProblem() const;
  void DescribeRecord(CaptureState& state) const;
  SharedCaptureState State();
  void Show(const std::function<void(const SharedCaptureState&)>& look);

  void Close();

  acquisition::Device& device_;
  const FrameSource source_ = device_.Source();  // all advice asks it
  tracking::PoseSource& poses_;
  const CaptureOptions options_;
  CaptureLens lens_;
  const CaptureHooks& hooks_;
  std::deque<Frame> first_;  // before the device is asked
  const std::filesystem::path root_;
  const std::function<void(const std::string&)> say_ = [this](const std::string& text) { Say(text); };
  CaptureRecord record_;
  PreflightReporter reporter_;
  CaptureSubject subject_;
  acquisition::RepeatedEvents repeated_;
  CaptureGaps gaps_;
  CaptureMeters meters_;
  CaptureRecorder recorder_;

  CapWatch cap_watch_{options_.until_share, options_.turntable.has_value(), source_};
  CaptureSummary summary_;
  std::vector<double> ms_track_;
  int map_revision_ = 0;  // of the tracker, as last seen
  bool poses_due_ = false;
  bool lens_doubted_ = false;  // and said so
  bool zoom_moved_ = false;
  std::uint64_t requests_answered_ = 0;
  bool finish_asked_ = false;
  std::optional<StoppedBecause> ended_;
  LatestFrame latest_;
  std::optional<Eigen::Quaterniond> last_turn_;  // cam_from_world of the last frame with a pose
  Guide guide_{options_.until_share};
  LightAndFocusCheck light_and_focus_;
  PictureFinding picture_;
  MistakeWatch mistakes_{source_};
  std::optional<double> shutter_asked_s_;
  SubjectProposer proposer_;
  std::optional<TurntableWatch> turntable_;
  bool waits_to_begin_ = false;
  std::optional<SetRecording> begin_asked_;  // while there is no subject
  std::vector<std::string> said_;            // of late
  std::uint64_t times_said_ = 0;
  double ended_after_s_ = 0;  // by this machine's clock
};

}  // namespace ulf::coverage
