// From a URI's scheme to the device behind it.
#include <algorithm>
#include <array>

#include "acquisition/aravis/aravis_device.h"
#include "acquisition/aravis/aravis_discovery.h"
#include "acquisition/device.h"
#include "acquisition/error.h"
#include "acquisition/replay_device.h"
#include "acquisition/simulator/simulated_device.h"

namespace ulf {
namespace {

constexpr const char* kWhatWorks =
    "sim:studio, replay:PATH and aravis:ID ('ulf devices' lists the cameras in reach)";

std::string FirstRealCamera() {
  std::string refused;
  for (const DeviceInfo& info : ListAravisDevices()) {
    if (info.available) return info.uri;
    refused += fmt::format("; {} {} {}: {}", info.maker, info.model, info.uri, info.problem);
  }
  throw Error(
      "no camera can be used: looked for GigE Vision on every network and for USB3 Vision{}. Connect one, or "
      "name sim:studio for the simulated one",
      refused);
}

}  // namespace

std::unique_ptr<Device> OpenDevice(const std::string& text) {
  const DeviceUri uri = DeviceUri::Parse(text.empty() ? FirstRealCamera() : text);
  if (uri.scheme == "sim") return OpenSimulatedDevice(uri);
  if (uri.scheme == "replay") return OpenReplayDevice(uri);
  if (uri.scheme == "aravis") return OpenAravisDevice(uri);
  constexpr std::array kLater = {"v4l2", "gphoto2"};
  if (std::find(kLater.begin(), kLater.end(), uri.scheme) != kLater.end())
    throw UsageError("'{}': this build cannot open {}: devices yet; it has {}", text, uri.scheme, kWhatWorks);
  throw UsageError("'{}': there is no kind of device called '{}'; there are {}", text, uri.scheme,
                   kWhatWorks);
}

std::vector<DeviceInfo> ListDevices() {
  std::vector<DeviceInfo> devices = ListAravisDevices();
  // Named without being opened: building its scene takes seconds.
  devices.push_back({.uri = "sim:studio",
                     .maker = "ULF",
                     .model = "simulated hand-held camera",
                     .serial = "",
                     .bus = "simulated",
                     .problem = ""});
  return devices;
}

}  // namespace ulf
