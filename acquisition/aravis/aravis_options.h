// What an `aravis:` URI asks of a camera (the options are told in aravis_device.h), before any camera is
// looked for.
#pragma once

#include <optional>
#include <string>

#include "acquisition/device/device.h"

namespace ulf::acquisition {

struct AravisRegion {
  int width = 0, height = 0, x = 0, y = 0;
};

struct AravisBinning {
  int x = 1, y = 1;
};

// Either once by the camera itself, or these ratios to green.
struct AravisWhiteBalance {
  bool by_camera = false;
  double red = 1, blue = 1;
};

enum class ThreadPriority { kNormal, kHigh, kRealtime };

struct AravisOptions {
  std::optional<std::string> user_set;
  std::optional<double> exposure_us, gain_db, black_level, fps;
  std::optional<int> gain_raw;
  std::optional<std::string> format;
  std::optional<AravisRegion> region;
  AravisBinning binning;
  std::optional<AravisWhiteBalance> white_balance;
  // Continuous automatics; none: those that are on run for settle_s and are then switched off.
  std::optional<bool> auto_exposure, auto_gain, auto_white_balance, auto_black_level;
  double settle_s = 1;
  std::string trigger = "free";  // "free", "software", or the camera's name for a line
  bool chunks = false;

  std::optional<int> packet_size, packet_delay_ns, packet_timeout_ms, frame_retention_ms;
  bool resend = true;
  std::optional<int> socket_buffer_bytes, buffers;
  ThreadPriority priority = ThreadPriority::kNormal;
  std::size_t queue = 4;

  bool Triggered() const { return trigger != "free"; }
  bool SoftwareTriggered() const { return trigger == "software"; }
};

// Throws UsageError naming the option that is unknown or makes no sense.
AravisOptions AravisOptionsOf(const DeviceUri& uri);

}  // namespace ulf::acquisition
