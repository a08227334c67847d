// Finishes `ulf capture` after the light field is closed: makes masks, merges brackets, keeps the tracker's
// map for the next session, prints the report, and writes the pictures that were asked for.
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
  acquisition::FrameRecorderSummary kept;  // frames of --keep-frames
  std::vector<TimedPose> truth;            // poses of --truth as the capture began; empty without it
  std::vector<TimedPose> live;             // poses of tracked frames as the tracker gave them
  std::optional<OpenedFolder> folder;      // the light field's; always set
};

// Returns the exit status: kFailed if the folder or device was lost, the disk was full, masks failed, nothing
// was recorded although nobody asked to end, or photographs do not follow one another. `hand` is what
// PrepareCapture() has set.
int CloseCapture(const CaptureArgs& args, const LensUseArgs& lens, const coverage::CaptureOptions& options,
                 PreparedCaptureCommand& hand, CaptureRun& run);

}  // namespace ulf::commands
