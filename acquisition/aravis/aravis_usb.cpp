#include "acquisition/aravis/aravis_usb.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <fstream>
#include <set>

#include "acquisition/device/device_files.h"
#include "core/base/file_descriptor.h"

namespace ulf::acquisition {
namespace {

// USB 2 signals 480 Mbit/s; of bulk data it carries at most 13 packets of 512 bytes in each 125 us, which is
// 53 MB/s, and controllers reach some 40. USB 3's first speed, 5 Gbit/s, carries some 400.
constexpr int kSuperSpeed = 5000;
constexpr double kHighSpeedBytes = 40e6, kSuperSpeedBytes = 400e6;

std::string Line(const std::filesystem::path& file) {
  std::string line;
  std::getline(std::ifstream(file) >> std::ws, line);
  return line;
}

int MegabitsOf(const std::filesystem::path& device) {
  int megabits = 0;
  std::ifstream(device / "speed") >> megabits;
  return megabits;
}

// "2-1.4" of "2-1.4.2" and "2-1.4.3.1"; empty where only the bus is common.
std::string CommonHub(const std::string& one, const std::string& other) {
  std::string hub;
  for (std::size_t end = one.find('.'); end != std::string::npos; end = one.find('.', end + 1))
    if (other.starts_with(one.substr(0, end + 1))) hub = one.substr(0, end);
  return hub;
}

int OpenError(const std::string& node) {
  const FileDescriptor file(open(node.c_str(), O_RDWR | O_CLOEXEC));
  return file.IsOpen() ? 0 : errno;
}

}  // namespace

std::vector<UsbCameraPlace> UsbCameraPlaces(const std::string& sysfs) {
  namespace fs = std::filesystem;
  std::vector<UsbCameraPlace> places;
  std::set<std::string> seen;
  std::error_code error;
  for (const fs::directory_entry& interface : fs::directory_iterator(sysfs, error)) {
    const std::string name = interface.path().filename();
    const std::size_t colon = name.find(':');
    if (colon == std::string::npos || Line(interface.path() / "bInterfaceClass") != "ef" ||
        Line(interface.path() / "bInterfaceSubClass") != "05" ||
        Line(interface.path() / "bInterfaceProtocol") != "00")
      continue;
    const std::string port = name.substr(0, colon);
    if (!seen.insert(port).second) continue;
    const fs::path device = interface.path().parent_path() / port;
    UsbCameraPlace place{
        .maker = Line(device / "manufacturer"),
        .model = Line(device / "product"),
        .serial = Line(device / "serial"),
        .node = fmt::format("/dev/bus/usb/{:0>3}/{:0>3}", Line(device / "busnum"), Line(device / "devnum")),
        .port = port};
    place.megabits = MegabitsOf(device);
    place.open_error = OpenError(place.node);
    places.push_back(std::move(place));
  }
  std::sort(places.begin(), places.end(),
            [](const UsbCameraPlace& a, const UsbCameraPlace& b) { return a.port < b.port; });
  return places;
}

std::optional<UsbCameraPlace> UsbCameraPlaceOf(const std::string& maker, const std::string& serial) {
  std::optional<UsbCameraPlace> found;
  for (UsbCameraPlace& place : UsbCameraPlaces()) {
    if (place.serial != serial || place.maker != maker) continue;
    if (found) return std::nullopt;
    found = std::move(place);
  }
  return found;
}

std::vector<UsbNeighbour> UsbNeighboursOf(const std::string& port, const std::string& sysfs) {
  namespace fs = std::filesystem;
  constexpr int kHighSpeed = 480;  // keyboards and mice, which are slower, take nothing that counts
  const std::string bus = port.substr(0, port.find('-') + 1);
  std::vector<UsbNeighbour> neighbours;
  std::error_code error;
  for (const fs::directory_entry& device : fs::directory_iterator(sysfs, error)) {
    const std::string other = device.path().filename();
    if (bus.empty() || !other.starts_with(bus) || other.find(':') != std::string::npos || other == port ||
        Line(device.path() / "bDeviceClass") == "09")
      continue;
    UsbNeighbour neighbour{
        .name = fmt::format("{} {}", Line(device.path() / "manufacturer"), Line(device.path() / "product")),
        .port = other,
        .megabits = MegabitsOf(device.path()),
        .hub = CommonHub(port, other)};
    if (neighbour.megabits < kHighSpeed) continue;
    if (!neighbour.hub.empty()) neighbour.hub_megabits = MegabitsOf(fs::path(sysfs) / neighbour.hub);
    neighbours.push_back(std::move(neighbour));
  }
  std::sort(neighbours.begin(), neighbours.end(),
            [](const UsbNeighbour& a, const UsbNeighbour& b) { return a.port < b.port; });
  return neighbours;
}

double UsbBytesPerSecond(int megabits) {
  if (megabits <= 0) return 0;
  return megabits < kSuperSpeed ? kHighSpeedBytes * megabits / 480
                                : kSuperSpeedBytes * megabits / kSuperSpeed;
}

std::string SlowUsbText(const UsbCameraPlace& place, std::size_t payload_bytes) {
  if (place.megabits <= 0 || place.megabits >= kSuperSpeed) return "";
  const double bytes = UsbBytesPerSecond(place.megabits);
  const std::string frames = payload_bytes > 0 ? fmt::format(", {:.3g} frames of this size",
                                                             bytes / static_cast<double>(payload_bytes))
                                               : "";
  return fmt::format(
      "connected at the speed of USB 2 ({} Mbit/s, port {}), which carries about {:.0f} MB a second{}; use a "
      "USB 3 port (blue, or marked SS) and a short USB 3 cable, without a USB 2 hub between",
      place.megabits, place.port, 1e-6 * bytes, frames);
}

std::string UsbOpenHint(const std::string& reason, const std::vector<UsbCameraPlace>& places) {
  if (reason.find("LIBUSB_ERROR_BUSY") != std::string::npos) {
    std::string who;
    for (const UsbCameraPlace& place : places)
      for (const std::string& holder : ProgramsHolding(place.node))
        who += fmt::format("{}{}", who.empty() ? ": " : ", ", holder);
    return fmt::format("another program uses this camera{}; close it, then try again", who);
  }
  if (reason.find("bootstrap") != std::string::npos)
    return "the camera is on the bus, but answers no request: pull its cable out and plug it in again";
  return "";
}

}  // namespace ulf::acquisition
