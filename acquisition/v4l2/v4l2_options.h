// What a `v4l2:` URI asks of a camera (told in v4l2_device.h), before any camera is looked for.
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
  double settle_s = 1;
  std::size_t queue = 4;
  std::vector<std::pair<std::string, std::string>> controls;  // in the URI's order
};

// Throws UsageError naming the option that makes no sense; control names are for the camera to know.
V4l2Options V4l2OptionsOf(const DeviceUri& uri);

}  // namespace ulf::acquisition
