#include "acquisition/gphoto2/gphoto_options.h"

#include <algorithm>

#include "core/base/error.h"
#include "core/base/lowercase.h"

namespace ulf::acquisition {
namespace {

constexpr const char* kNetworkDriver = "PTP/IP Camera";
constexpr int kPtpipPort = 15740;

// Converts "ptpip:ADDRESS" or "ptpip:ADDRESS:PORT" to the driver's form, with the port for both connections.
GphotoAddress NetworkAddress(const DeviceUri& uri) {
  const std::string rest = uri.path.substr(std::string("ptpip:").size());
  const std::size_t colon = rest.find(':');
  const std::string host = rest.substr(0, colon);
  int port = kPtpipPort;
  if (colon != std::string::npos) {
    const std::string text = rest.substr(colon + 1, rest.find(':', colon + 1) - colon - 1);
    const bool digits = !text.empty() && text.size() <= 5 &&
                        std::all_of(text.begin(), text.end(), [](char c) { return c >= '0' && c <= '9'; });
    port = digits ? std::stoi(text) : 0;
    if (port < 1 || port > 65535)
      throw Refused(uri, fmt::format("'{}' is not a port", text),
                    "write ptpip:ADDRESS or ptpip:ADDRESS:PORT");
  }
  if (host.empty()) throw Refused(uri, "give the camera's address: gphoto2:ptpip:192.168.1.9");
  return {kNetworkDriver, fmt::format("ptpip:{}:{}:{}", host, port, port)};
}

std::string ListOf(const std::vector<GphotoAddress>& found) {
  std::string list;
  for (const GphotoAddress& camera : found)
    list += fmt::format("{}{} (gphoto2:{})", list.empty() ? "" : "; ", camera.model, camera.port);
  return list;
}

bool HasSerial(const DeviceUri& uri, const GphotoAddress& address) {
  try {
    GphotoCamera camera(uri.Text(), address);
    const auto serial = camera.Setting("serialnumber");
    return serial && Lowercase(serial->value) == Lowercase(uri.path);
  } catch (const Error&) {
    return false;  // a camera that cannot be opened does not tell its serial number
  }
}

}  // namespace

GphotoOptions GphotoOptions::Of(const DeviceUri& uri) {
  std::vector<std::string> known{"target", "liveview_fps", "shutter_lag_ms", "queue"};
  for (const ShotSetting setting : kShotSettings) known.push_back(Name(setting));
  known.push_back("reconnect_s");
  uri.AllowOnly(known);
  GphotoOptions options;
  // In the order in which they are written: the exposure program decides what else can be set.
  for (const ShotSetting setting : {ShotSetting::kProgram, ShotSetting::kFormat, ShotSetting::kFocus,
                                    ShotSetting::kAperture, ShotSetting::kShutter, ShotSetting::kIso})
    if (const auto value = uri.Option(Name(setting))) options.settings.emplace_back(setting, *value);
  if (const auto target = uri.Option("target")) {
    if (*target != "card" && *target != "ram")
      throw Refused(uri, fmt::format("target must be card or ram, not '{}'", *target));
    options.to_card = *target == "card";
  }
  options.live_view_fps = uri.Number("liveview_fps", options.live_view_fps, 0.1, 120);
  options.shutter_lag_s = uri.Number("shutter_lag_ms", 0, 0, 10'000) / 1000;
  options.queue = static_cast<std::size_t>(uri.Number("queue", 4, 1, 1000));
  return options;
}

GphotoAddress ResolveGphotoAddress(const DeviceUri& uri) {
  if (uri.path.starts_with("ptpip:")) return NetworkAddress(uri);
  const std::vector<GphotoAddress> found = DetectGphotoCameras();
  if (found.empty())
    throw Error(
        "{}: found no tethered camera at a USB port; connect one, switch it on and choose PTP (not mass "
        "storage) in its menu, or name a network camera: gphoto2:ptpip:ADDRESS",
        uri.Text());
  if (uri.path.empty()) return found.front();
  for (const GphotoAddress& camera : found)
    if (camera.port == uri.path) return camera;
  std::vector<GphotoAddress> matching;
  for (const GphotoAddress& camera : found)
    if (Lowercase(camera.model).find(Lowercase(uri.path)) != std::string::npos) matching.push_back(camera);
  if (matching.empty() && !uri.path.starts_with("usb:"))
    for (const GphotoAddress& camera : found)
      if (HasSerial(uri, camera)) matching.push_back(camera);
  if (matching.size() == 1) return matching.front();
  if (matching.empty())
    throw Error("{}: no camera has this port, model or serial number; found: {}", uri.Text(), ListOf(found));
  throw Error("{}: names more than one camera; give a port: {}", uri.Text(), ListOf(matching));
}

DeviceInfo DescribeGphoto(GphotoCamera& camera, const std::string& uri, const std::string& bus) {
  const auto text = [&](const char* name) {
    const auto setting = camera.Setting(name);
    return setting ? setting->value : std::string();
  };
  return {.uri = uri,
          .maker = text("manufacturer"),
          .model = text("cameramodel"),
          .serial = text("serialnumber"),
          .bus = bus,
          .problem = {}};
}

}  // namespace ulf::acquisition
