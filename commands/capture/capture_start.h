// Prepares a capture (coverage/session/prepared_capture.h) from the arguments of `ulf capture`.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "acquisition/calibration/intrinsics.h"
#include "coverage/session/prepared_capture.h"
#include "coverage/session/record/capture_options.h"
#include "coverage/simulated_operator/simulated_operator.h"
#include "tracking/sources/poses_spec.h"
#include "tracking/tracker/tracker_options.h"

namespace ulf::commands {

// The values of the options, which `ulf capture --help` describes; an empty one or 0 was not given.
struct CaptureArgs {
  std::string uri;
  std::string dir;
  std::string subject = "auto";
  double subject_size = coverage::CaptureOptions{}.subject_size;
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
  std::string turntable;
  tracking::ReadoutArgs readout;
  tracking::LensUse lens = tracking::LensUse::kCheck;
  bool lens_is_asked = false;
  int tracking_side_px = tracking::TrackerOptions{}.max_side_px;
  tracking::PosesSpec poses;  // what PosesFrom() returns for these arguments
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

// Combines `poses_text` and `turntable`. Throws UsageError for both, and for a turntable of several markers.
tracking::PosesSpec PosesFrom(const CaptureArgs& args);

// Returns the options that do not depend on the device; `args.poses` must be set. Throws UsageError for
// values that are impossible or contradict each other.
coverage::CaptureOptions OptionsFrom(const CaptureArgs& args);

struct PreparedCaptureCommand : coverage::PreparedCapture {
  std::shared_ptr<coverage::SimulatedOperator> person;  // of --operator; null without it
};

// Opens the device and calls coverage::PrepareCapture(), whose contract holds: false means stopped before the
// first frame. `options`, from OptionsFrom(), is completed by what device and folder say; `hand` is set.
bool PrepareCapture(const CaptureArgs& args, coverage::CaptureOptions* options, PreparedCaptureCommand& hand);

}  // namespace ulf::commands
