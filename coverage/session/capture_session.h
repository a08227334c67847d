// A capture: frames in, views out, and why not. Each frame gets a pose, a decision with its reason, and, when
// recorded, a place in the light field on disk.
//
// Device and tracking share the caller's thread; a second one writes (view_spool.h). With `deterministic`
// everything happens in one thread, host times are the device's, and the same frames give the same bytes.
//
// A device that goes away and comes back leaves a gap in the journal and in the poses, nothing more: the
// tracker finds itself again. A disk that is full or slow pauses the recording, not the tracking; that is a
// gap, too. Both are said at once, and counted at the end.
//
// Views hang on the tracker's keyframes: when the map is adjusted, their poses are corrected, journaled at
// intervals and at the end, and the coverage map is painted anew; what fell open again is said. What a person
// asks for (capture_request.h) is done between two frames.
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
#include "coverage/session/capture_request.h"
#include "coverage/session/capture_state.h"
#include "coverage/session/record/posed_photographs.h"
#include "coverage/session/record/still_capture.h"
#include "coverage/session/record/view_spool.h"
#include "tracking/sources/pose_source.h"

namespace ulf::coverage {

struct CaptureOptions {
  std::optional<Subject>
      subject;                 // none: from the tracked points near the image centre, once tracking is stable
  double subject_size = 0.28;  // then the sphere's image as a share of the image's width
  int stable_frames = 10;      // tracked in a row before the subject is placed
  std::optional<Cap> cap;      // with one, the capture ends when enough of it is covered
  double until_share = 0.98;
  double threshold_px = 7;
  int coverage_width_px = 640;
  // Where the intrinsics come from, for whoever wants to know before the first view; calibrated: false for a
  // focal length alone.
  std::string calibration_source;
  std::optional<bool> calibrated;
  // With one, photographs of this camera are recorded instead of live frames (still_capture.h); the device
  // takes them.
  std::optional<CameraModel> still_camera;
  // With one there is no subject, no map and no cap: photographs of a walk (posed_photographs.h).
  std::optional<PhotographSpacing> without_subject;
  DecisionLimits limits;
  bool deterministic = false;
  std::uint64_t max_frames = 0;  // 0: no limit
  double max_seconds = 0;        // of the device's time; 0: no limit
  std::size_t spool_views = 16;
  int frames_between_pose_updates = 60;
};

using SharedCaptureState = std::shared_ptr<const CaptureState>;

struct CaptureHooks {
  std::function<bool()> stop_requested;  // asked before every frame
  CaptureRequests* requests = nullptr;   // answered between two frames
  // Every complete live frame and every photograph, before it is looked at.
  std::function<void(const Frame&)> keep_frame;
  // What there is to see then (capture_state.h); it is made only for who asks.
  std::function<void(const SharedCaptureState&)> after_frame;
  // Ten times a second when no frame comes, after every photograph, and once at the end, before the light
  // field is closed.
  std::function<void(const SharedCaptureState&)> while_waiting;
  std::function<void(const std::string&)> say;  // what happened, a line, once
};

struct CaptureSummary {
  std::uint64_t frames = 0;      // complete frames that were looked at; the device counts the others
  std::uint64_t recorded = 0;    // views of this session that are in the light field
  std::uint64_t taken_back = 0;  // views that are not any more, as asked
  StillCounts stills;            // of a device that takes photographs
  std::array<std::uint64_t, kReasons.size()> reasons{};  // by Reason
  double ms_track_median = 0;
  double ms_decide_median = 0;
  StoppedBecause stopped_because = StoppedBecause::kEnded;
  std::string problem;  // what the disk said; empty otherwise
  acquisition::DeviceStatistics device;
  std::map<std::string, std::uint64_t> events;  // of the device, by Name(kind)
  std::uint64_t pauses = 0;                     // of the recording, for the disk
  double paused_s = 0;
  // When the disk filled up or failed: frames that were taken and are nowhere, and frames that are not in the
  // light field but in these folders.
  std::uint64_t unwritten = 0;
  std::map<std::filesystem::path, std::size_t> set_aside;
  std::optional<tracking::CalibrationCheck>
      calibration;                                   // what the tracker's map says about the focal length
  std::optional<tracking::Readout> rolling_shutter;  // and about the shutter; none: global as far as is known
  std::optional<Subject> subject;
  bool subject_was_found = false;                     // by the capture itself, not given
  std::shared_ptr<const RecordedView> last_recorded;  // null: none
  std::shared_ptr<const CoverageMap>
      map;  // as it was at the end, with final poses; none when no subject was found
};

// Runs until the cap is covered, the device ends, a limit is reached or a stop is asked for; then stops the
// device, adjusts the map, brings all poses up to date and closes the light field. The device has been
// started; what was taken from it already (a live frame to learn its size, photographs before that) is
// `first`. `writer` may come from
// LightFieldWriter::Resume: its views are taken over as they are. Throws what the device throws.
CaptureSummary RunCapture(acquisition::Device& device, const CameraModel& camera, tracking::PoseSource& poses,
                          LightFieldWriter writer, const CaptureOptions& options,
                          const CaptureHooks& hooks = {}, std::vector<Frame> first = {});

}  // namespace ulf::coverage
