// Reads from the system what the library does not report about USB3 Vision cameras (interface class 0xEF,
// 0x05): where they are plugged in, at which speed, and who may open them.
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
// Returns the camera with this serial number; none where there is none, or several.
std::optional<UsbCameraPlace> UsbCameraPlaceOf(const std::string& maker, const std::string& serial);

// Another device that may share the bandwidth of a camera's link: on its bus, at 480 Mbit/s or more.
struct UsbNeighbour {
  std::string name;  // maker and product
  std::string port;
  int megabits = 0;
  // The nearest hub that the data of both pass, "2-1"; empty: each has a port of the controller.
  std::string hub;
  int hub_megabits = 0;  // of that hub's own link to the computer
};
// Returns the other devices on the bus of the device at `port`, by port, without hubs.
std::vector<UsbNeighbour> UsbNeighboursOf(const std::string& port,
                                          const std::string& sysfs = "/sys/bus/usb/devices");

// Returns how many bytes of pixels such a link carries a second; 0: unknown.
double UsbBytesPerSecond(int megabits);
// Returns a message when the camera is connected at less than USB 3, with what to do and, for a given
// payload, the most frames a second; empty when it is not.
std::string SlowUsbText(const UsbCameraPlace& place, std::size_t payload_bytes = 0);
// Returns what to do when the library could not open a USB camera for this reason; empty if unknown.
std::string UsbOpenHint(const std::string& reason, const std::vector<UsbCameraPlace>& places);

}  // namespace ulf::acquisition
