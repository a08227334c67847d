// What a gphoto2 URI says, and which camera it means.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "acquisition/device/device.h"
#include "acquisition/gphoto2/camera_settings.h"
#include "acquisition/gphoto2/gphoto_camera.h"

namespace ulf::acquisition {

struct GphotoOptions {
  std::vector<std::pair<ShotSetting, std::string>> settings;
  std::optional<bool> to_card;  // none: to the card where there is one
  double live_view_fps = 15;
  double shutter_lag_s = 0;
  std::size_t queue = 4;

  static GphotoOptions Of(const DeviceUri& uri);  // throws UsageError
};

// The address of `path` in `gphoto2:path`; by name or serial number it is looked for. Throws Error with what
// there is instead.
GphotoAddress ResolveGphotoAddress(const DeviceUri& uri);

}  // namespace ulf::acquisition
