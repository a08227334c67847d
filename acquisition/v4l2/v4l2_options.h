// The options of a `v4l2:` URI (v4l2_device.h), parsed before any camera is opened.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "acquisition/device/device.h"
#include "acquisition/v4l2/v4l2_modes.h"
#include "acquisition/v4l2/v4l2_stream.h"

namespace ulf::acquisition {

struct V4l2Options {
  V4l2ModeRequest request;
  V4l2Io io = V4l2Io::kMmap;
  double settle_s = 1;    // the automatics run so long; guessed: webcams adapt within a second
  std::size_t queue = 4;  // frames that may wait for the reader
  std::vector<std::pair<std::string, std::string>> controls;  // in the URI's order
};

// Throws Refusal that names the invalid option. Names of controls are checked when the camera is open.
V4l2Options V4l2OptionsOf(const DeviceUri& uri);

}  // namespace ulf::acquisition
