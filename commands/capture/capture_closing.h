// What `ulf capture` does when the light field is closed: masks, the map for the next session, merged
// brackets, the report, pictures, and the words that a person should read last.
#pragma once

#include <optional>
#include <vector>

#include "acquisition/device/frame_recording.h"
#include "commands/capture/capture_start.h"
#include "commands/options/tracking_options.h"
#include "core/geometry/trajectory.h"
#include "core/light_field/folder/opened_folder.h"
#include "coverage/session/capture_options.h"
#include "coverage/session/capture_summary.h"

namespace ulf::commands {

// What a capture has left behind.
struct CaptureRun {
  coverage::CaptureSummary summary;
  acquisition::FrameRecorderSummary kept;  // frames, where they were to be kept
  std::vector<TimedPose> truth;            // as given; empty: none
  std::vector<TimedPose> live;             // of tracked frames, as they were tracked
  std::optional<OpenedFolder> folder;      // the light field's
};

// Returns the command's exit status.
int CloseCapture(const CaptureArgs& args, const LensUseArgs& lens, const coverage::CaptureOptions& options,
                 CaptureInHand& hand, CaptureRun& run);

}  // namespace ulf::commands
