// What was asked for on the command line of a capture.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "acquisition/calibration/intrinsics.h"
#include "coverage/session/capture_session.h"
#include "tracking/sources/pose_source.h"
#include "tracking/tracker/tracker_options.h"

namespace ulf::coverage {

struct CaptureArgs {
  std::string uri;
  std::string dir;
  std::string subject = "auto";
  double subject_size = 0.28;
  bool no_subject = false;
  std::optional<double> parallax_deg;
  std::string until_covered;
  std::string quality;
  std::optional<double> threshold_px;
  std::optional<int> coverage_width_px;
  acquisition::IntrinsicsArgs intrinsics;
  std::string poses_text = "features";
  tracking::ReadoutArgs readout;
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
  bool deterministic = false;
  bool resume = false;
  bool raw = false;
  bool json = false;
  std::string overlay;
  std::string map;
  std::string truth;
};

// What of it can be known before there is a device. Throws UsageError.
CaptureOptions OptionsFrom(const CaptureArgs& args);

}  // namespace ulf::coverage
