// What a capture is asked for, and what it calls while it runs (capture_session.h).
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "coverage/bound/capture_presets.h"
#include "coverage/bound/coverage_map.h"
#include "coverage/bound/view_decision.h"
#include "coverage/measured/cover_by.h"
#include "coverage/session/capture_request.h"
#include "coverage/session/capture_state.h"
#include "coverage/session/record/bracket_capture.h"
#include "coverage/session/record/posed_photographs.h"
#include "tracking/sources/poses_spec.h"

namespace ulf::coverage {

struct CaptureOptions {
  // None: found from the tracked points near the image centre, once tracking is stable.
  std::optional<Subject> subject;
  double subject_size = kSubjectSize;  // of a found subject: its sphere's image, share of the image's width
  int stable_frames = kStableFrames;   // tracked in a row before the subject is found
  std::optional<Cap> cap;              // with one, the capture ends when enough of it is covered
  double until_share = kUntilShare;
  double threshold_px = kHighThresholdPx;
  int coverage_width_px = kCoverageWidthPx;
  // Shown before the first view: where the intrinsics come from, and whether they are a calibration (false: a
  // focal length alone).
  std::string calibration_source;
  std::optional<bool> calibrated;
  // As the tracker was told. kRefine: where it goes on with another lens, so does the capture, with what it
  // has recorded (capture_lens.h); then no view of an earlier session must be there.
  tracking::LensUse lens = tracking::LensUse::kCheck;
  // Set: photographs of this camera, which the device takes, are recorded instead of live frames
  // (still_capture.h).
  std::optional<CameraModel> still_camera;
  // Set: the camera stands, and the subject turns on these markers, in whose frame the poses are: the subject
  // is looked for above them, and the capture says when nothing turns or the camera was moved
  // (turntable_watch.h).
  std::optional<tracking::MarkerSpec> turntable;
  // Set: no subject, no coverage map and no cap; photographs of a walk (posed_photographs.h).
  std::optional<PhotographSpacing> without_subject;
  // Frames of a place whose way to the recorded views is not known (TrackState::kApart) are kept in unposed/,
  // as many as show something new; refining may find where they were taken.
  bool keep_apart = false;
  // Set: so many exposures of each view. The device takes them (Device::TakesExposures) and knows its
  // exposure time.
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
  std::uint64_t max_frames = 0;           // 0: no limit
  double max_seconds = 0;                 // of the device's time; 0: no limit
  std::size_t spool_views = kSpoolViews;  // that may wait for the disk; more and recording pauses
  int frames_between_pose_updates = 60;
  std::size_t lines_shown = 3;  // of the session's messages: as many as a person can read at once
};

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

}  // namespace ulf::coverage
