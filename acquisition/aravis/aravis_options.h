// Reads the options of an `aravis:` URI (docs/devices.md#options-of-aravis) before any camera is opened.
#pragma once

#include <optional>
#include <string>

#include "acquisition/device/device.h"

namespace ulf::acquisition {

// A part of the image, in pixels after binning.
struct AravisRegion {
  int width = 0, height = 0, x = 0, y = 0;
  bool operator==(const AravisRegion&) const = default;
};

struct AravisBinning {
  int x = 1, y = 1;
};

// The camera adjusts its white balance once by itself, or takes these ratios to green.
struct AravisWhiteBalance {
  bool by_camera = false;
  double red = 1, blue = 1;
};

enum class ThreadPriority { kNormal, kHigh, kRealtime };

struct AravisOptions {
  std::optional<std::string> user_set;  // settings stored in the camera, which are loaded first
  std::optional<double> exposure_us, gain_db, fps;
  std::optional<double> black_level;  // in the camera's unit
  std::optional<int> gain_raw;        // in the camera's unit
  std::optional<std::string> format;  // a pixel format of PFNC
  std::optional<AravisRegion> region;
  AravisBinning binning;
  std::optional<AravisWhiteBalance> white_balance;
  // Whether an automatic runs continuously; none: one that is on runs for settle_s, then it is switched off.
  std::optional<bool> auto_exposure, auto_gain, auto_white_balance, auto_black_level;
  double settle_s = 1;           // guessed: webcams and machine-vision cameras settle within a second
  std::string trigger = "free";  // "free", "software", or the camera's name for a line
  bool chunks = false;
  std::optional<bool> ptp;  // whether IEEE 1588 sets the camera's clock; none: as the camera is set
  double ptp_wait_s = 30;   // for a PTP master; guessed: masters announce themselves every second or two

  std::optional<double> throughput_limit;  // bytes a second
  std::optional<int> packet_size, packet_delay_ns, packet_timeout_ms, frame_retention_ms;
  bool resend = true;
  std::optional<int> socket_buffer_bytes, buffers;
  ThreadPriority priority = ThreadPriority::kNormal;
  std::size_t queue = 4;  // frames that may wait for the reader; guessed

  bool Triggered() const { return trigger != "free"; }
  bool SoftwareTriggered() const { return trigger == "software"; }
};

// Throws Refusal naming the option that is unknown or makes no sense.
AravisOptions AravisOptionsOf(const DeviceUri& uri);

}  // namespace ulf::acquisition
