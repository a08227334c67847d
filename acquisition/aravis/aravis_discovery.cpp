#include "acquisition/aravis/aravis_device.h"

#include <algorithm>
#include <cerrno>

#include "acquisition/aravis/aravis_calls.h"
#include "acquisition/aravis/aravis_usb.h"
#include "acquisition/gige_vision/gige_vision_probe.h"
#include "core/base/mutex.h"

namespace ulf::acquisition {
namespace {

struct Discovered {
  std::string id, physical_id, address, vendor, model, serial, protocol;

  bool IsGige() const { return protocol == "GigEVision"; }
  // GigE Vision cameras are opened by address, which needs no discovery and works through routers.
  std::string OpenBy() const { return IsGige() && !address.empty() ? address : id; }
  bool IsNamed(const std::string& name) const {
    return name == id || name == serial || name == physical_id || name == address ||
           name == vendor + "-" + serial || name == vendor + "-" + model + "-" + serial;
  }
};

std::vector<Discovered> Discover() {
  static Mutex mutex;  // the library has one list per process
  const MutexLock lock(mutex);
  arv_update_device_list();
  std::vector<Discovered> found;
  for (unsigned i = 0; i < arv_get_n_devices(); ++i)
    found.push_back({Text(arv_get_device_id(i)), Text(arv_get_device_physical_id(i)),
                     Text(arv_get_device_address(i)), Text(arv_get_device_vendor(i)),
                     Text(arv_get_device_model(i)), Text(arv_get_device_serial_nbr(i)),
                     Text(arv_get_device_protocol(i))});
  return found;
}

bool IsIpv4(const std::string& text) {
  if (text.find('.') == std::string::npos || !g_hostname_is_ip_address(text.c_str())) return false;
  return text.find(':') == std::string::npos;
}

std::string GigeProblem(const Discovered& camera) {
  const GigeControl control = QueryGigeControl(camera.address);
  if (control == GigeControl::kFree) return "";
  if (control == GigeControl::kControlled) {
    const std::string who = QueryGigeController(camera.address);
    return fmt::format(
        "another program controls it{}; close that program (its control ends some seconds later)",
        who.empty() ? "" : ", from " + who);
  }
  for (const GigeAnswer& answer : DiscoverGigeCameras())
    if (answer.address == camera.address) {
      std::string wrong_network = WrongNetworkText(answer, NetworkInterfaces());
      if (!wrong_network.empty()) return wrong_network;
    }
  return "answers discovery but not at its own address " + camera.address +
         "; check the firewall (UDP port 3956) and the routes to it";
}

// USB cameras whose node this user may not open. The library does not list them, because it must open a
// device to read its name.
std::vector<DeviceInfo> ForbiddenUsbCameras() {
  std::vector<DeviceInfo> list;
  for (const UsbCameraPlace& place : UsbCameraPlaces())
    if (place.open_error == EACCES || place.open_error == EPERM)
      list.push_back({.uri = "aravis:" + place.serial,
                      .maker = place.maker,
                      .model = place.model,
                      .serial = place.serial,
                      .bus = "USB3Vision",
                      .available = false,
                      .problem = place.node +
                                 " may not be opened by this user; install udev/70-ulf-cameras.rules in "
                                 "/etc/udev/rules.d, run 'udevadm control --reload', then plug the camera in "
                                 "again"});
  return list;
}

}  // namespace

std::string ResolveAravis(const std::string& uri, const std::string& id) {
  if (IsIpv4(id)) return id;
  const std::vector<Discovered> found = Discover();
  if (found.empty()) {
    std::string forbidden;
    for (const DeviceInfo& camera : ForbiddenUsbCameras())
      forbidden += fmt::format("; {} {}: {}", camera.maker, camera.model, camera.problem);
    throw Error(
        "{}: no camera answers; searched for GigE Vision on every network and for USB3 Vision{}. Check "
        "power, cable and firewall (UDP port 3956), name the camera's address if it is behind a router, or "
        "use sim:studio",
        uri, forbidden);
  }
  if (id.empty()) return found.front().OpenBy();
  std::vector<Discovered> matching;
  std::string list;
  for (const Discovered& camera : found) {
    if (camera.IsNamed(id)) matching.push_back(camera);
    list += fmt::format("{}{} (serial {}, {})", list.empty() ? "" : "; ", camera.id, camera.serial,
                        camera.OpenBy());
  }
  if (matching.empty()) throw Error("{}: no camera is named '{}'; found: {}", uri, id, list);
  const bool ambiguous = std::any_of(matching.begin(), matching.end(), [&](const Discovered& camera) {
    return camera.physical_id != matching.front().physical_id || camera.address != matching.front().address;
  });
  if (ambiguous) throw Error("{}: '{}' names more than one camera; give an address: {}", uri, id, list);
  return matching.front().OpenBy();
}

std::vector<DeviceInfo> ListAravisDevices() {
  std::vector<DeviceInfo> list;
  for (const Discovered& camera : Discover()) {
    DeviceInfo info{.uri = "aravis:" + camera.OpenBy(),
                    .maker = camera.vendor,
                    .model = camera.model,
                    .serial = camera.serial,
                    .bus = camera.protocol,
                    .problem = ""};
    if (camera.IsGige()) {
      info.address = camera.address;
      info.problem = GigeProblem(camera);
    }
    info.available = info.problem.empty();
    if (!camera.IsGige())
      if (const auto place = UsbCameraPlaceOf(camera.vendor, camera.serial))
        info.remark = SlowUsbText(*place);
    list.push_back(info);
  }
  for (DeviceInfo& camera : ForbiddenUsbCameras()) list.push_back(std::move(camera));
  return list;
}

}  // namespace ulf::acquisition
