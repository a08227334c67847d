// Reads the options of a `gphoto2:` URI (gphoto_device.h), and finds the camera that it names.
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
  std::vector<std::pair<ShotSetting, std::string>> settings;  // in the order in which they are written
  std::optional<bool> to_card;                                // none: to the card where there is one
  double live_view_fps = 15;
  double shutter_lag_s = 0;  // from the request for a photograph to its exposure
  std::size_t queue = 4;     // live frames that may wait for the reader

  static GphotoOptions Of(const DeviceUri& uri);  // throws Refusal
};

// Returns the address of the camera that the URI names; searches for a model or serial number. Throws Error
// that lists the cameras found if none or several match.
GphotoAddress ResolveGphotoAddress(const DeviceUri& uri);

// Returns maker, model and serial number of an open camera; `bus`: "USB" or "PTP/IP".
DeviceInfo DescribeGphoto(GphotoCamera& camera, const std::string& uri, const std::string& bus);

}  // namespace ulf::acquisition
