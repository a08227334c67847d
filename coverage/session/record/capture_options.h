// Defines the options of a capture (capture_session.h).
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "acquisition/calibration/intrinsics.h"
#include "coverage/bound/capture_presets.h"
#include "coverage/bound/coverage_map.h"
#include "coverage/measured/cover_by.h"
#include "coverage/session/record/bracket_capture.h"
#include "coverage/session/record/posed_photographs.h"
#include "tracking/sources/marker_spec.h"
#include "tracking/tracker/tracker_options.h"

namespace ulf::coverage {

struct CaptureOptions {
  // None: the capture finds the subject from the tracked points near the image centre, once
  // tracking is stable.
  std::optional<Subject> subject;
  double subject_size = kSubjectSize;  // width of a found sphere's image, share of the picture's width
  int stable_frames = kStableFrames;   // how many are tracked in a row before the subject is found
  std::optional<Cap> cap;              // with one, the capture ends when `until_share` of it is covered
  double until_share = kUntilShare;
  double threshold_px = kHighThresholdPx;
  int coverage_width_px = kCoverageWidthPx;
  // For the preflight: where the intrinsics are from, and whether they are a calibration (true) or a focal
  // length alone (false); none: not known.
  std::string calibration_source;
  std::optional<bool> calibrated;
  acquisition::LensOrigin lens_origin = acquisition::LensOrigin::kMeasured;
  // The tracker's LensUse. kRefine: when it replaces the lens, the capture does so for everything recorded
  // (capture_lens.h); the light field must then have no view of an earlier session.
  tracking::LensUse lens = tracking::LensUse::kCheck;
  bool LensMayChange() const { return lens == tracking::LensUse::kRefine; }
  // If it is set, photographs that the device takes with this camera are recorded instead of live frames
  // (still_capture.h).
  std::optional<CameraModel> still_camera;
  // If it is set, the subject turns on these markers before a fixed camera, and poses are in the markers'
  // frame. The subject is searched above them, and the capture reports when nothing turns or the camera was
  // moved (turntable_watch.h).
  std::optional<tracking::MarkerSpec> turntable;
  // If it is set, posed photographs (posed_photographs.h) are recorded, without subject,
  // coverage map and cap.
  std::optional<PhotographSpacing> without_subject;
  // Frames of TrackState::kApart that show something new are kept in unposed/: refining may find their poses.
  bool keep_apart = false;
  // If it is set, each view gets so many exposures, from a device that takes them (Device::TakesExposures)
  // and knows its exposure time.
  std::optional<ExposureBracket> bracket;
  // Makes depth maps and a mesh while the capture goes on (live_geometry.h). Needs a subject.
  bool geometry = false;
  CoverGoal cover;  // what decides that a viewpoint is covered; all but the bound needs `geometry`
  // Nothing is recorded before a request (SetRecording), so that the subject can be placed first. Failed
  // checks hold the start (preflight.h). A light field that already has views resumes without a request.
  bool begins_on_request = false;
  bool checks_hold_start = true;
  bool deterministic = false;             // everything runs in one thread (capture_session.h)
  std::uint64_t max_frames = 0;           // 0: no limit
  double max_seconds = 0;                 // of the device's time; 0: no limit
  std::size_t spool_views = kSpoolViews;  // how many may wait for the disk before recording pauses
  int frames_between_pose_updates = 60;   // how often the views' poses follow the tracker's map
};

}  // namespace ulf::coverage
