// What an `aravis:` URI asks of a camera (the options are told in aravis_device.h), before any camera is
// looked for.
#pragma once

#include <optional>
#include <string>

#include "acquisition/device.h"

namespace ulf {

struct AravisRegion {
  int width = 0, height = 0, x = 0, y = 0;
};

struct AravisOptions {
  std::optional<double> exposure_us, gain_db, fps;
  std::optional<std::string> format;
  std::optional<AravisRegion> region;
  std::optional<int> packet_size;
  std::size_t queue = 4;
};

// Throws UsageError naming the option that is unknown or makes no sense.
AravisOptions AravisOptionsOf(const DeviceUri& uri);

}  // namespace ulf
