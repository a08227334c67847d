// The options of a `gphoto2:` URI (gphoto_device.h), and the camera that it names.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "acquisition/device/device.h"
#include "acquisition/gphoto2/camera_settings.h"
#include "acquisition/gphoto2/gphoto_camera.h"

namespace ulf::acquisition {

// Seconds. Guessed, except where stated.
struct GphotoPatience {
  double pair_s = 3;               // a raw file and its JPEG wait so long for each other
  double busy_s = 10;              // a busy camera may delay the release so long, then the request fails
  double photograph_s = 60;        // from release to announcement: long exposures, slow cards
  double last_photograph_s = 10;   // Stop() waits so long for a photograph that was requested before
  double watch_every_s = 5;        // interval at which settings, battery and card are checked
  double live_view_trouble_s = 3;  // live view may fail so long before kStalled is reported
  double live_view_repeat_s = 30;  // interval at which kStalled is then repeated
  double live_view_pause_s = 0.3;  // pause after a failed live view frame
};

struct GphotoOptions {
  std::vector<std::pair<ShotSetting, std::string>> settings;
  std::optional<bool> to_card;  // none: to the card where there is one
  double live_view_fps = 15;
  double shutter_lag_s = 0;
  std::size_t queue = 4;     // live frames that may wait for the reader
  int battery_low = 15;      // percent; at or below, a notice tells it; guessed
  int failures_in_row = 20;  // then a camera that cannot report its storage is lost; guessed
  GphotoPatience patience;

  static GphotoOptions Of(const DeviceUri& uri);  // throws Refusal
};

// The address of `path` in `gphoto2:path`; a name or serial number is searched for. Throws Error that lists
// the cameras found.
GphotoAddress ResolveGphotoAddress(const DeviceUri& uri);

// Maker, model and serial number of an open camera; `bus`: "USB" or "PTP/IP".
DeviceInfo DescribeGphoto(GphotoCamera& camera, const std::string& uri, const std::string& bus);

}  // namespace ulf::acquisition
