#include "acquisition/aravis/aravis_options.h"

#include <cstdio>

#include "core/base/error.h"
#include "core/frames/pixel_format.h"

namespace ulf::acquisition {
namespace {

std::optional<bool> OnOrOff(const DeviceUri& uri, const std::string& key) {
  const auto text = uri.Option(key);
  if (!text) return std::nullopt;
  if (*text != "on" && *text != "off") throw Refused(uri, fmt::format("{} must be on or off", key));
  return *text == "on";
}

AravisRegion ParseRegion(const DeviceUri& uri, const std::string& text) {
  AravisRegion region;
  char rest = 0;
  if (std::sscanf(text.c_str(), "%dx%d+%d+%d%c", &region.width, &region.height, &region.x, &region.y,
                  &rest) != 4 ||
      region.width < 1 || region.height < 1 || region.x < 0 || region.y < 0)
    throw Refused(uri, "roi must read WIDTHxHEIGHT+X+Y, such as 640x480+0+0");
  return region;
}

AravisBinning ParseBinning(const DeviceUri& uri, const std::string& text) {
  AravisBinning binning;
  char rest = 0;
  if (std::sscanf(text.c_str(), "%dx%d%c", &binning.x, &binning.y, &rest) != 2 || binning.x < 1 ||
      binning.y < 1)
    throw Refused(uri, "binning must read 2x2");
  return binning;
}

AravisWhiteBalance ParseWhiteBalance(const DeviceUri& uri, const std::string& text) {
  AravisWhiteBalance balance;
  if (text == "auto") {
    balance.by_camera = true;
    return balance;
  }
  char rest = 0;
  if (std::sscanf(text.c_str(), "%lf,%lf%c", &balance.red, &balance.blue, &rest) != 2 ||
      !(balance.red > 0 && balance.blue > 0))
    throw Refused(uri, "white_balance must read RED,BLUE, ratios to green such as 1.6,2.1, or auto");
  return balance;
}

ThreadPriority ParsePriority(const DeviceUri& uri, const std::string& text) {
  if (text == "normal") return ThreadPriority::kNormal;
  if (text == "high") return ThreadPriority::kHigh;
  if (text == "realtime") return ThreadPriority::kRealtime;
  throw Refused(uri, "priority must be normal, high or realtime");
}

// Throws Refusal where the automatic is on and an option sets a value that it controls (`controls`).
std::optional<bool> ParseAutomatic(const DeviceUri& uri, const std::string& key,
                                   std::initializer_list<const char*> controls) {
  const std::optional<bool> on = OnOrOff(uri, key);
  for (const char* value : controls)
    if (on == true && uri.Option(value))
      throw Refused(uri, fmt::format("{}=on would change {} again", key, value), "give only one of them");
  return on;
}

}  // namespace

AravisOptions AravisOptionsOf(const DeviceUri& uri) {
  uri.AllowOnly({"exposure_us",
                 "gain_db",
                 "gain_raw",
                 "black_level",
                 "fps",
                 "format",
                 "roi",
                 "binning",
                 "white_balance",
                 "auto_exposure",
                 "auto_gain",
                 "auto_white_balance",
                 "auto_black_level",
                 "settle",
                 "trigger",
                 "user_set",
                 "chunks",
                 "ptp",
                 "ptp_wait_s",
                 "packet_size",
                 "packet_delay_ns",
                 "throughput_limit",
                 "resend",
                 "packet_timeout_ms",
                 "frame_retention_ms",
                 "socket_buffer",
                 "buffers",
                 "priority",
                 "queue",
                 "reconnect_s"});
  AravisOptions options;
  options.user_set = uri.Option("user_set");
  options.exposure_us = uri.Number("exposure_us");
  options.gain_db = uri.Number("gain_db");
  options.gain_raw = uri.Whole("gain_raw", 0, 1'000'000);
  if (options.gain_db && options.gain_raw)
    throw Refused(uri, "gain_db and gain_raw both set the gain", "give only one of them");
  options.black_level = uri.Number("black_level");
  options.fps = uri.Number("fps");
  options.format = uri.Option("format");
  if (options.format && !PixelFormatByName(*options.format))
    throw Refused(uri, fmt::format("the pixel format {} is not supported", *options.format),
                  fmt::format("supported are {}", SupportedPixelFormats()));
  if (const auto text = uri.Option("roi")) options.region = ParseRegion(uri, *text);
  if (const auto text = uri.Option("binning")) options.binning = ParseBinning(uri, *text);
  if (const auto text = uri.Option("white_balance")) options.white_balance = ParseWhiteBalance(uri, *text);
  options.auto_exposure = ParseAutomatic(uri, "auto_exposure", {"exposure_us"});
  options.auto_gain = ParseAutomatic(uri, "auto_gain", {"gain_db", "gain_raw"});
  options.auto_white_balance = ParseAutomatic(uri, "auto_white_balance", {"white_balance"});
  options.auto_black_level = ParseAutomatic(uri, "auto_black_level", {"black_level"});
  options.settle_s = uri.Number("settle", options.settle_s, 0, 60);
  if (const auto text = uri.Option("trigger")) options.trigger = *text;
  options.chunks = OnOrOff(uri, "chunks").value_or(false);
  options.ptp = OnOrOff(uri, "ptp");
  options.ptp_wait_s = uri.Number("ptp_wait_s", options.ptp_wait_s, 0, 600);

  options.packet_size = uri.Whole("packet_size", 1, 1'000'000);
  options.packet_delay_ns = uri.Whole("packet_delay_ns", 0, 1'000'000'000);
  options.throughput_limit = uri.Number("throughput_limit");
  options.resend = OnOrOff(uri, "resend").value_or(true);
  options.packet_timeout_ms = uri.Whole("packet_timeout_ms", 1, 10'000);
  options.frame_retention_ms = uri.Whole("frame_retention_ms", 1, 10'000);
  options.socket_buffer_bytes = uri.Whole("socket_buffer", 1, 1 << 30);
  options.buffers = uri.Whole("buffers", 2, 1000);
  if (const auto text = uri.Option("priority")) options.priority = ParsePriority(uri, *text);
  if (const auto queue = uri.Whole("queue", 1, 1'000'000)) options.queue = static_cast<std::size_t>(*queue);
  return options;
}

}  // namespace ulf::acquisition
