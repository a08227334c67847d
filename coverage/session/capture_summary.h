// Defines the result of a capture (capture_session.h).
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/device/device.h"
#include "coverage/bound/coverage_map.h"
#include "coverage/bound/view_decision.h"
#include "coverage/measured/cover_by.h"
#include "coverage/measured/error_map.h"
#include "coverage/session/capture_state.h"
#include "coverage/session/record/bracket_capture.h"
#include "coverage/session/record/capture_record.h"
#include "coverage/session/record/recorded_views.h"
#include "coverage/session/record/still_capture.h"
#include "coverage/session/watch/mistake_watch.h"
#include "tracking/estimation/calibration_check.h"
#include "tracking/tracker/readout.h"
#include "tracking/tracker/start_progress.h"

namespace ulf::coverage {

// The errors that were measured at frames (coverage/measured).
struct MeasuredSummary {
  std::uint64_t frames = 0;  // how many were measured
  double ms_median = 0;      // processor time of a measurement
  CoverGoal cover;
  ErrorSummary errors;
};

struct CaptureSummary : ClosedRecord {
  FrameSource source = FrameSource::kCamera;
  std::uint64_t frames = 0;      // complete live frames that were processed; `device` counts the others
  std::uint64_t taken_back = 0;  // views that were removed on request
  std::uint64_t kept_apart = 0;  // frames in unposed/ (CaptureOptions::keep_apart)
  std::map<tracking::StartObstacle, std::uint64_t> start_obstacles;  // frames that each kept a map from
  BracketCounts brackets;                                            // CaptureOptions::bracket
  StillCounts stills;                                                // of a device that takes photographs
  std::array<std::uint64_t, kReasons.size()> reasons{};              // by Reason
  double ms_track_median = 0;                                        // time of the tracker for a frame
  double ms_decide_median = 0;                                       // time of a decision
  StoppedBecause stopped_because = StoppedBecause::kEnded;
  acquisition::DeviceStatistics device;
  std::vector<NoticedMistake> mistakes;
  std::map<std::string, std::uint64_t> events;  // of the device, by Name(kind)
  std::uint64_t pauses = 0;                     // of the recording, for the disk
  double paused_s = 0;                          // their length in all
  // The map's evidence about the lens, and about the shutter (none: global as far as is known).
  std::optional<tracking::CalibrationCheck> calibration;
  std::optional<tracking::Readout> rolling_shutter;
  // The lens that replaced the given one, in the light field as well; none: the given one stayed.
  std::optional<tracking::RefinedLens> refined_lens;
  std::optional<Subject> subject;
  bool subject_was_found = false;                      // by the capture itself, not given
  std::shared_ptr<const RecordedFrame> last_recorded;  // null: none
  std::shared_ptr<const CoverageMap> map;              // with final poses; null without a subject
  std::optional<MeasuredSummary> measured;             // none: nothing was measured
  std::shared_ptr<const ErrorMap> errors;              // null: nothing was measured
};

}  // namespace ulf::coverage
