// Prepares a capture (capture_session.h) from a device, a lens, a source of poses and a folder. Where these
// do not fit together it refuses and writes nothing but the photographs that a camera took before.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "acquisition/calibration/intrinsics.h"
#include "acquisition/device/device.h"
#include "acquisition/device/frame_recording.h"
#include "core/base/stop_signal.h"
#include "core/frames/frame.h"
#include "core/geometry/camera_model.h"
#include "coverage/session/record/capture_options.h"
#include "tracking/sources/poses_spec.h"
#include "tracking/tracker/tracker_options.h"

namespace ulf::coverage {

struct SessionArgs {
  std::string uri;                                                  // of the device, as messages name it
  std::string dir;                                                  // of the light field
  std::function<std::unique_ptr<acquisition::Device>()> open = {};  // empty: OpenDevice(uri)
  acquisition::IntrinsicsArgs intrinsics = {};
  tracking::PosesSpec poses = {};
  tracking::ReadoutArgs readout = {};
  tracking::LensUse lens = tracking::LensUse::kCheck;
  // In place of kCheck a lens of which nothing is known is sought (kRefine) where the pictures are taken
  // already: nobody can calibrate it.
  bool seeks_unknown_lens = false;
  int tracking_side_px = tracking::TrackerOptions{}.max_side_px;
  bool resume = false;  // goes on with the light field in `dir`
  bool raw = false;     // masters are the mosaics of a mosaic camera
  // Whether the caller gives CaptureOptions::threshold_px, and its cap with until_share. If not, those of a
  // resumed light field count.
  bool threshold_is_given = false, goal_is_given = false;
  std::function<bool()> stop = StopOnSignal::Requested;  // asked while the first frame is awaited
};

// Keeps the photographs of a capture that could not begin, and those still to be downloaded, in the light
// field's unposed/ where there is one (`writer`), else beside `dir` (kept_photographs.h). Reports on stderr
// where they are and what could not be kept. Stops the device.
void KeepPhotographs(acquisition::Device& device, const std::vector<Frame>& taken, LightFieldWriter* writer,
                     const std::filesystem::path& dir);

struct PreparedCapture {
  std::unique_ptr<acquisition::Device> device;
  std::vector<Frame> first;                // what came until the first live frame, which is the last
  CameraModel camera;                      // of live frames
  acquisition::RecordingHeader recording;  // what a recording of the frames says of the session
  std::unique_ptr<tracking::PoseSource> poses;
  std::unique_ptr<LightFieldWriter> writer;
};

// Returns false when a stop was asked for before the first live frame: then no light field has been made.
// Photographs that came before it, or before a refusal, are kept (KeepPhotographs). `options` is completed by
// what device and folder say. Throws Refusal for what does not fit together, Error for what cannot be opened,
// read or written.
bool PrepareCapture(const SessionArgs& args, CaptureOptions* options, PreparedCapture& prepared);

}  // namespace ulf::coverage
