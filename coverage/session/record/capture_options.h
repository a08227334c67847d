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
  // None: it is found from the tracked points near the image centre, once tracking is stable.
  std::optional<Subject> subject;
  double subject_size = kSubjectSize;  // of a found subject: its sphere's image, share of the image's width
  int stable_frames = kStableFrames;   // tracked in a row before the subject is found
  std::optional<Cap> cap;              // with one, the capture ends when enough of it is covered
  double until_share = kUntilShare;
  double threshold_px = kHighThresholdPx;
  int coverage_width_px = kCoverageWidthPx;
  // The preflight shows the source of the intrinsics, and whether it is a calibration or a focal length
  // alone.
  std::string calibration_source;
  std::optional<bool> calibrated;
  acquisition::LensOrigin lens_origin = acquisition::LensOrigin::kMeasured;
  // The tracker's LensUse. kRefine: when it replaces the lens, the capture does so for everything recorded
  // (capture_lens.h); the light field must then have no view of an earlier session.
  tracking::LensUse lens = tracking::LensUse::kCheck;
  bool LensMayChange() const { return lens == tracking::LensUse::kRefine; }
  // Set: photographs of this camera, which the device takes, are recorded instead of live frames
  // (still_capture.h).
  std::optional<CameraModel> still_camera;
  // Set: the subject turns on these markers before a fixed camera, and poses are in the markers' frame. The
  // subject is searched above them, and the capture reports when nothing turns or the camera was moved
  // (turntable_watch.h).
  std::optional<tracking::MarkerSpec> turntable;
  // Set: records posed photographs (posed_photographs.h) without subject, coverage map and cap.
  std::optional<PhotographSpacing> without_subject;
  // Frames of TrackState::kApart that show something new are kept in unposed/: refining may find their poses.
  bool keep_apart = false;
  // Set: each view gets so many exposures, from a device that takes them (Device::TakesExposures) and knows
  // its exposure time.
  std::optional<ExposureBracket> bracket;
  bool geometry =
      false;        // depth maps and a mesh while the capture goes on (live_geometry.h); needs a subject
  CoverGoal cover;  // what decides that a viewpoint is covered; all but the bound needs `geometry`
  // Nothing is recorded before a request (SetRecording), so that the subject can be placed first. Failed
  // checks hold the start (preflight.h). A light field that already has views resumes without a request.
  bool begins_on_request = false;
  bool checks_hold_start = true;
  bool deterministic = false;
  std::uint64_t max_frames = 0;           // 0: no limit
  double max_seconds = 0;                 // of the device's time; 0: no limit
  std::size_t spool_views = kSpoolViews;  // that may wait for the disk; more and recording pauses
  int frames_between_pose_updates = 60;
};

}  // namespace ulf::coverage
