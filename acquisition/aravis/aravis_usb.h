// What the system knows of USB3 Vision cameras (interface class 0xEF, 0x05) that the library does not tell:
// where they are plugged in, at which speed, and who may open them.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace ulf::acquisition {

struct UsbCameraPlace {
  std::string maker, model, serial;
  std::string node;    // "/dev/bus/usb/002/003"
  std::string port;    // "2-1.4": bus, and the ports on the way
  int megabits = 0;    // a second, as host and camera agreed; 0: unknown
  int open_error = 0;  // why this user may not open the node; 0: may
};

// `sysfs`: the folder of the kernel's USB devices.
std::vector<UsbCameraPlace> UsbCameraPlaces(const std::string& sysfs = "/sys/bus/usb/devices");
// The one with this serial number; none where there is none, or several.
std::optional<UsbCameraPlace> UsbCameraPlaceOf(const std::string& maker, const std::string& serial);

// Another device that may take of what a camera's link carries: on its bus, at 480 Mbit/s or more.
struct UsbNeighbour {
  std::string name;  // maker and product
  std::string port;
  int megabits = 0;
  // "2-1": the hub nearest to both that all their data pass; empty: only the controller's own, each has a
  // port of it.
  std::string hub;
  int hub_megabits = 0;  // of that hub's own link to the computer
};
// What hangs on the same bus as the device at `port`, by port; hubs themselves are not named.
std::vector<UsbNeighbour> UsbNeighboursOf(const std::string& port,
                                          const std::string& sysfs = "/sys/bus/usb/devices");

// How many bytes a second such a link carries of pixels; 0: unknown.
double UsbBytesPerSecond(int megabits);
// That it is connected at less than USB 3, and what to do; empty where it is not. With a payload also the
// most frames a second.
std::string SlowUsbText(const UsbCameraPlace& place, std::size_t payload_bytes = 0);
// What to do when the library could not open a USB camera, from what it said; empty where nothing is known.
std::string UsbOpenHint(const std::string& reason, const std::vector<UsbCameraPlace>& places);

}  // namespace ulf::acquisition
