// A capture: the loop that turns a device's frames into the views of a light field. Each frame gets a pose
// (tracking/) and a decision with its reason (view_decision.h); a frame that is recorded becomes a view on
// disk.
//
// The device and the tracker run in the caller's thread, writing in others (view_spool.h). With
// `deterministic` everything runs in one thread, host times are the device's times, and the same frames give
// the same bytes.
//
// When the device disappears and comes back, the tracker relocalises; the journal notes the gap. When the disk
// is full or slow, recording pauses and tracking goes on; the journal notes that gap, too. Both are reported
// at once and counted at the end.
//
// Each view is anchored to a keyframe of the tracker's map. When the map is adjusted, the views' poses follow:
// they are journaled at intervals and at the end, and the coverage map is painted anew. The same where the tracker
// replaces the lens (LensUse::kRefine). Requests (capture_request.h) are answered between two frames.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/device/device.h"
#include "core/light_field/light_field_io.h"
#include "coverage/bound/coverage_map.h"
#include "coverage/bound/view_decision.h"
#include "coverage/measured/cover_by.h"
#include "coverage/measured/error_map.h"
#include "coverage/session/capture_request.h"
#include "coverage/session/capture_state.h"
#include "coverage/session/record/bracket_capture.h"
#include "coverage/session/record/live_geometry.h"
#include "coverage/session/record/posed_photographs.h"
#include "coverage/session/record/still_capture.h"
#include "coverage/session/record/view_spool.h"
#include "tracking/sources/poses_spec.h"

namespace ulf::coverage {

struct CaptureOptions {
  // None: found from the tracked points near the image centre, once tracking is stable.
  std::optional<Subject> subject;
  double subject_size = 0.28;  // of a found subject: its sphere's image, share of the image's width
  int stable_frames = 10;      // tracked in a row before the subject is found
  std::optional<Cap> cap;      // with one, the capture ends when enough of it is covered
  double until_share = 0.98;
  double threshold_px = 7;
  int coverage_width_px = 640;
  // Shown before the first view: where the intrinsics come from, and whether they are a calibration (false: a
  // focal length alone).
  std::string calibration_source;
  std::optional<bool> calibrated;
  // As the tracker was told. kRefine: where it goes on with another lens, so does the capture, with what it has recorded
  // (capture_lens.h); then no view of an earlier session must be there.
  tracking::LensUse lens = tracking::LensUse::kCheck;
  // Set: photographs of this camera, which the device takes, are recorded instead of live frames
  // (still_capture.h).
  std::optional<CameraModel> still_camera;
  // Set: the camera stands, and the subject turns on these markers, in whose frame the poses are: the subject is
  // looked for above them, and the capture says when nothing turns or the camera was moved (turntable_watch.h).
  std::optional<tracking::MarkerSpec> turntable;
  // Set: no subject, no coverage map and no cap; photographs of a walk (posed_photographs.h).
  std::optional<PhotographSpacing> without_subject;
  // Frames of a place whose way to the recorded views is not known (TrackState::kApart) are kept in unposed/, as many as
  // show something new, for `ulf refine --unposed`.
  bool keep_apart = false;
  // Set: so many exposures of each view. The device takes them (Device::TakesExposures) and knows its exposure time.
  std::optional<ExposureBracket> bracket;
  DecisionLimits limits;
  bool geometry =
      false;        // depth maps and a mesh while the capture goes on (live_geometry.h); needs a subject
  CoverGoal cover;  // what decides that a viewpoint is covered; all but the bound needs `geometry`
  // Nothing is recorded before somebody asks for it (SetRecording), so that the subject can be placed first.
  // Failed checks hold the start (preflight.h). A light field that already has views goes on by itself.
  bool begins_on_request = false;
  bool checks_hold_start = true;
  bool deterministic = false;
  std::uint64_t max_frames = 0;  // 0: no limit
  double max_seconds = 0;        // of the device's time; 0: no limit
  std::size_t spool_views = 16;  // that may wait for the disk; more and recording pauses
  int frames_between_pose_updates = 60;
  std::size_t lines_shown = 3;  // of the session's messages: as many as a person can read at once
};

using SharedCaptureState = std::shared_ptr<const CaptureState>;

struct CaptureHooks {
  std::function<bool()> stop_requested;  // asked before every frame
  CaptureRequests* requests = nullptr;   // answered between two frames
  // Every complete live frame and every photograph, before it is processed.
  std::function<void(const Frame&)> keep_frame;
  // The state after a frame (capture_state.h); made only when this hook is set.
  std::function<void(const SharedCaptureState&)> after_frame;
  // Ten times a second when no frame comes, after every photograph, and once at the end, before the light
  // field is closed.
  std::function<void(const SharedCaptureState&)> while_waiting;
  std::function<void(const std::string&)> say;  // a line for each event
  // The capture has ended, and now does this, in words, which may take long.
  std::function<void(const std::string&)> closing;
};

// The error that was measured at frames (coverage/measured).
struct MeasuredSummary {
  std::uint64_t frames = 0;  // at which it was measured
  double ms_median = 0;      // of processor time
  CoverGoal cover;
  ErrorSummary errors;
};

struct CaptureSummary {
  FrameSource source = FrameSource::kCamera;
  std::uint64_t frames = 0;      // complete frames that were processed; the device counts the others
  std::uint64_t recorded = 0;    // views of this session that are in the light field
  std::uint64_t taken_back = 0;  // views that were removed on request
  std::uint64_t kept_apart = 0;  // frames in unposed/ (CaptureOptions::keep_apart)
  std::map<tracking::StartObstacle, std::uint64_t> start_obstacles;  // frames that each kept a map from
  BracketCounts brackets;                                            // CaptureOptions::bracket
  StillCounts stills;                                                // of a device that takes photographs
  std::array<std::uint64_t, kReasons.size()> reasons{};              // by Reason
  double ms_track_median = 0;
  double ms_decide_median = 0;
  StoppedBecause stopped_because = StoppedBecause::kEnded;
  std::string problem;  // the disk's error; empty: none
  acquisition::DeviceStatistics device;
  std::vector<NoticedMistake> mistakes;
  std::map<std::string, std::uint64_t> events;  // of the device, by Name(kind)
  std::uint64_t pauses = 0;                     // of the recording, for the disk
  double paused_s = 0;
  // When the disk filled up or failed: accepted frames that are lost, and accepted frames that were written to
  // these folders instead of the light field.
  std::uint64_t unwritten = 0;
  std::map<std::filesystem::path, std::size_t> set_aside;
  // What the tracker's map says about the focal length, and about the shutter; none: global as far as is known.
  std::optional<tracking::CalibrationCheck> calibration;
  std::optional<tracking::Readout> rolling_shutter;
  // That took the given one's place, in the light field as well; none: the given one stayed.
  std::optional<tracking::RefinedLens> refined_lens;
  std::optional<Subject> subject;
  bool subject_was_found = false;                      // by the capture itself, not given
  std::shared_ptr<const RecordedFrame> last_recorded;  // null: none
  std::shared_ptr<const CoverageMap> map;              // with final poses; null without a subject
  std::optional<FinishedGeometry> geometry;            // none: not asked for
  std::optional<MeasuredSummary> measured;             // none: nothing was measured
  std::shared_ptr<const ErrorMap> errors;              // null: nothing was measured
};

// Runs until the cap is covered, the device ends, a limit is reached or a stop is requested; then stops the
// device, finishes the adjustment of the tracker's map, brings all poses up to date and closes the light
// field. `device` has been started; `first` are the frames that were read from it before (a live frame to
// learn its size, photographs before that one). `writer` may come from LightFieldWriter::Resume: the capture
// goes on with its views. Throws what the device throws.
CaptureSummary RunCapture(acquisition::Device& device, const CameraModel& camera, tracking::PoseSource& poses,
                          LightFieldWriter writer, const CaptureOptions& options,
                          const CaptureHooks& hooks = {}, std::vector<Frame> first = {});

}  // namespace ulf::coverage
