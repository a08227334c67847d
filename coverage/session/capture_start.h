// From the command line to a capture that can run: device, intrinsics, poses and folder that fit together, or a
// refusal that has written nothing. Keeps photographs that a camera takes before there is a light field.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/calibration/intrinsics.h"
#include "acquisition/device/device.h"
#include "acquisition/device/frame_recording.h"
#include "core/light_field/light_field_io.h"
#include "coverage/session/capture_session.h"
#include "coverage/simulated_operator/simulated_operator.h"
#include "tracking/sources/poses_spec.h"
#include "tracking/tracker/tracker_options.h"

namespace ulf::coverage {

// As on the command line.
struct CaptureArgs {
  std::string uri;
  std::string dir;
  std::string subject = "auto";
  double subject_size = CaptureOptions{}.subject_size;
  bool no_subject = false;
  std::optional<double> parallax_deg;
  bool keep_apart = false;
  std::string bracket;
  std::string until_covered;
  std::string quality;
  std::optional<double> threshold_px;
  std::optional<int> coverage_width_px;
  acquisition::IntrinsicsArgs intrinsics;
  std::string poses_text = "features";
  // The markers on which the subject turns, as --poses markers: has them; empty: the subject stands still.
  std::string turntable;
  tracking::ReadoutArgs readout;
  tracking::LensUse lens = tracking::LensUse::kCheck;
  int tracking_side_px = tracking::TrackerOptions{}.max_side_px;
  tracking::PosesSpec poses;
  std::uint64_t frames = 0;
  double max_seconds = 0;
  std::optional<double> speed;
  std::string keep_frames;
  std::string person;
  std::string requests;
  bool headless = false;
  bool offscreen = false;
  std::string marker;
  bool force_start = false;
  bool no_geometry = false;
  std::string cover = "bound";
  bool deterministic = false;
  bool resume = false;
  bool raw = false;
  bool json = false;
  std::string overlay;
  std::string map;
  std::string error_map;
  std::string truth;
};

// `--poses` and `--turntable` as one. Throws UsageError where they contradict each other.
tracking::PosesSpec PosesFrom(const CaptureArgs& args);

// The options that do not depend on the device. Throws UsageError.
CaptureOptions OptionsFrom(const CaptureArgs& args);

// Takes frames from a started device up to its first complete live frame, which is the last of `taken`;
// photographs that are released on the body meanwhile come before it. False when a stop was asked for first.
// Throws Error when no live frame comes; `taken` then holds the photographs.
bool TakeFirstFrames(acquisition::Device& device, const std::string& uri, const std::function<bool()>& stop,
                     std::vector<Frame>& taken);

// A capture that could not begin has photographs in hand: they, and those on their way, go to the light
// field's unposed/ where there is one (`writer`), else beside `dir` (kept_photographs.h). Says where on
// stderr, and what could not be kept. Stops the device.
void KeepPhotographs(acquisition::Device& device, const std::vector<Frame>& taken, LightFieldWriter* writer,
                     const std::filesystem::path& dir);

struct PreparedCapture {
  std::unique_ptr<acquisition::Device> device;
  std::shared_ptr<SimulatedOperator> person;  // who holds a simulated camera, if anybody
  std::vector<Frame> first;                   // what came until the first live frame, which is the last
  CameraModel camera;                         // of live frames
  acquisition::RecordingHeader recording;     // what --keep-frames says of the session
  std::unique_ptr<tracking::PoseSource> poses;
  std::unique_ptr<LightFieldWriter> writer;
};

// False when a signal came before the first frame: then nothing has been written. Photographs that came
// before it, or before a refusal, are kept (KeepPhotographs). `options` is completed by what device and
// folder say.
bool PrepareCapture(const CaptureArgs& args, CaptureOptions* options, PreparedCapture& prepared);

}  // namespace ulf::coverage
