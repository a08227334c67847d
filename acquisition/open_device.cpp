// From a URI's scheme to the device behind it.
#include <algorithm>
#include <array>

#include "acquisition/aravis/aravis_device.h"
#include "acquisition/aravis/aravis_discovery.h"
#include "acquisition/device.h"
#include "acquisition/error.h"
#include "acquisition/replay_device.h"
#include "acquisition/simulator/simulated_device.h"
#include "acquisition/v4l2/v4l2_device.h"

namespace ulf {
namespace {

constexpr const char* kWhatWorks =
    "sim:studio, replay:PATH, aravis:ID and v4l2:/dev/video0 ('ulf devices' lists the cameras in reach)";

// Machine-vision cameras before webcams.
std::vector<DeviceInfo> RealCameras() {
  std::vector<DeviceInfo> cameras = ListAravisDevices();
  for (DeviceInfo& webcam : ListV4l2Devices()) cameras.push_back(std::move(webcam));
  return cameras;
}

std::string FirstRealCamera() {
  std::string refused;
  for (const DeviceInfo& info : RealCameras()) {
    if (info.available) return info.uri;
    refused += fmt::format("; {} {} {}: {}", info.maker, info.model, info.uri, info.problem);
  }
  throw Error(
      "no camera can be used: looked for GigE Vision on every network, for USB3 Vision and for webcams{}. "
      "Connect "
      "one, or name sim:studio for the simulated one",
      refused);
}

}  // namespace

std::unique_ptr<Device> OpenDevice(const std::string& text) {
  const DeviceUri uri = DeviceUri::Parse(text.empty() ? FirstRealCamera() : text);
  if (uri.scheme == "sim") return OpenSimulatedDevice(uri);
  if (uri.scheme == "replay") return OpenReplayDevice(uri);
  if (uri.scheme == "aravis") return OpenAravisDevice(uri);
  if (uri.scheme == "v4l2") return OpenV4l2Device(uri);
  constexpr std::array kLater = {"gphoto2"};
  if (std::find(kLater.begin(), kLater.end(), uri.scheme) != kLater.end())
    throw UsageError("'{}': this build cannot open {}: devices yet; it has {}", text, uri.scheme, kWhatWorks);
  throw UsageError("'{}': there is no kind of device called '{}'; there are {}", text, uri.scheme,
                   kWhatWorks);
}

std::vector<DeviceInfo> ListDevices() {
  std::vector<DeviceInfo> devices = RealCameras();
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
