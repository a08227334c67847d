#include "acquisition/opening/open_device.h"

#include "acquisition/aravis/aravis_device.h"
#include "acquisition/device/reconnecting_device.h"
#include "acquisition/device/replay_device.h"
#include "acquisition/gphoto2/gphoto_device.h"
#include "acquisition/simulator/simulated_device.h"
#include "acquisition/v4l2/v4l2_device.h"
#include "core/base/error.h"

namespace ulf::acquisition {
namespace {

constexpr const char* kDeviceKinds =
    "sim:studio, replay:PATH, aravis:ID, v4l2:/dev/video0 and gphoto2:ID ('ulf devices' lists the cameras in "
    "reach)";

// Lists machine-vision cameras first, webcams last.
std::vector<DeviceInfo> RealCameras() {
  std::vector<DeviceInfo> cameras = ListAravisDevices();
  for (DeviceInfo& tethered : ListGphotoDevices()) cameras.push_back(std::move(tethered));
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
      "no camera can be used: searched for GigE Vision on every network, USB3 Vision, tethered cameras and "
      "webcams{}. Connect a camera, or name sim:studio for the simulated one",
      refused);
}

// Removes the option `reconnect_s`, which no driver knows, and returns its value.
double ExtractPatience(DeviceUri& uri) {
  const double patience_s = uri.Number("reconnect_s").value_or(Reconnection{}.patience_s);
  if (patience_s < 0) throw Refused(uri, "reconnect_s must be 0 (do not search) or a number of seconds");
  std::erase_if(uri.options, [](const auto& option) { return option.first == "reconnect_s"; });
  return patience_s;
}

// `left` is shared by the drivers that open the same tethered camera one after the other.
std::unique_ptr<Device> OpenDriver(const DeviceUri& uri, const std::shared_ptr<UnfetchedPhotographs>& left) {
  if (uri.scheme == "sim") return OpenSimulatedDevice(uri);
  if (uri.scheme == "aravis") return OpenAravisDevice(uri);
  if (uri.scheme == "v4l2") return OpenV4l2Device(uri);
  if (uri.scheme == "gphoto2") return OpenGphotoDevice(uri, left);
  throw Refused(uri, fmt::format("there is no kind of device called '{}'", uri.scheme),
                fmt::format("there are {}", kDeviceKinds));
}

std::vector<DeviceInfo> ListOf(const std::string& scheme) {
  if (scheme == "aravis") return ListAravisDevices();
  if (scheme == "v4l2") return ListV4l2Devices();
  if (scheme == "gphoto2") return ListGphotoDevices();
  return {};
}

// Opens the same camera at its present address, with its old options. Finds it by its serial number, or as
// the only camera of its model where it has none.
std::unique_ptr<Device> OpenElsewhere(const DeviceInfo& known,
                                      const std::shared_ptr<UnfetchedPhotographs>& left) {
  DeviceUri uri = DeviceUri::Parse(known.uri);
  std::vector<DeviceInfo> same;
  for (const DeviceInfo& info : ListOf(uri.scheme))
    if (known.serial.empty() ? info.serial.empty() && info.maker == known.maker && info.model == known.model
                             : info.serial == known.serial)
      same.push_back(info);
  if (same.size() != 1)
    throw Error("{}: {} {}{} is not found; check power and cable", known.uri, known.maker, known.model,
                known.serial.empty() ? "" : ", serial " + known.serial + ",");
  uri.path = DeviceUri::Parse(same.front().uri).path;
  return OpenDriver(uri, left);
}

}  // namespace

std::unique_ptr<Device> OpenDevice(const std::string& text) {
  DeviceUri uri = DeviceUri::Parse(text.empty() ? FirstRealCamera() : text);
  if (uri.scheme == "replay") return OpenReplayDevice(uri);
  const double patience_s = ExtractPatience(uri);
  const auto left = std::make_shared<UnfetchedPhotographs>();
  return MakeReconnectingDevice(
      OpenDriver(uri, left),
      {.where_it_was =
           [left](const DeviceInfo& known) { return OpenDriver(DeviceUri::Parse(known.uri), left); },
       .elsewhere = [left](const DeviceInfo& known) { return OpenElsewhere(known, left); },
       .patience_s = patience_s});
}

std::unique_ptr<FeatureAccess> OpenFeatures(const std::string& text) {
  const DeviceUri uri = DeviceUri::Parse(text);
  if (uri.scheme == "aravis") return OpenAravisFeatures(uri);
  if (uri.scheme == "v4l2") return OpenV4l2Features(uri);
  if (uri.scheme == "gphoto2") return OpenGphotoFeatures(uri);
  throw Refused(fmt::format("'{}'", text),
                "only cameras have features (aravis:ID, v4l2:/dev/video0, gphoto2:ID)",
                "'ulf devices' lists those in reach");
}

std::vector<DeviceInfo> ListDevices() {
  std::vector<DeviceInfo> devices = RealCameras();
  // Lists the simulated camera without opening it: building its scene takes seconds.
  devices.push_back({.uri = "sim:studio",
                     .maker = "ULF",
                     .model = "simulated hand-held camera",
                     .serial = "",
                     .bus = "simulated",
                     .problem = ""});
  return devices;
}

}  // namespace ulf::acquisition
