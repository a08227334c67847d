// Finishes `ulf capture` when the light field is closed: masks, the map for the next session, merged
// brackets, the report, pictures, and final messages.
#pragma once

#include <optional>
#include <vector>

#include "acquisition/device/frame_recording.h"
#include "commands/capture/capture_start.h"
#include "commands/options/tracking_options.h"
#include "core/geometry/trajectory.h"
#include "core/light_field/folder/opened_folder.h"
#include "coverage/session/capture_summary.h"
#include "coverage/session/record/capture_options.h"

namespace ulf::commands {

// The results of a finished capture.
struct CaptureRun {
  coverage::CaptureSummary summary;
  acquisition::FrameRecorderSummary kept;  // recorded frames, if requested
  std::vector<TimedPose> truth;            // as they were at the start; empty if none
  std::vector<TimedPose> live;             // live poses of tracked frames
  std::optional<OpenedFolder> folder;      // of the light field
};

// Returns the command's exit status.
int CloseCapture(const CaptureArgs& args, const LensUseArgs& lens, const coverage::CaptureOptions& options,
                 PreparedCaptureCommand& hand, CaptureRun& run);

}  // namespace ulf::commands
