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
  std::string port;    // "2-1.4": the bus and the ports on the way, as the kernel names them
  int megabits = 0;    // a second, as host and camera agreed; 0: unknown
  int open_error = 0;  // errno of opening the node as this user; 0: it can be opened
};

// Returns all USB3 Vision cameras, in the order of their ports. `sysfs`: the kernel's folder of USB devices.
std::vector<UsbCameraPlace> UsbCameraPlaces(const std::string& sysfs = "/sys/bus/usb/devices");
// Returns the camera of this maker and serial number; none if there is none, or several.
std::optional<UsbCameraPlace> UsbCameraPlaceOf(const std::string& maker, const std::string& serial);

// Another device of 480 Mbit/s or more on a camera's bus, which may share the bandwidth of its link.
struct UsbNeighbour {
  std::string name;  // maker and product
  std::string port;
  int megabits = 0;
  // The port of the nearest hub that the data of both pass, "2-1"; empty: they share the controller only.
  std::string hub;
  int hub_megabits = 0;  // of that hub's own link to the computer
};
// Returns the other devices on the bus of the device at `port`, in the order of their ports, without hubs.
std::vector<UsbNeighbour> UsbNeighboursOf(const std::string& port,
                                          const std::string& sysfs = "/sys/bus/usb/devices");

// Returns how many bytes of pixels a link of this speed carries a second; 0 if the speed is unknown.
double UsbBytesPerSecond(int megabits);
// Returns a message if the camera is connected at less than USB 3, with what to do and, for a payload above
// 0, the most frames a second; else an empty text.
std::string SlowUsbText(const UsbCameraPlace& place, std::size_t payload_bytes = 0);
// Returns what to do when Aravis could not open a USB camera for `reason`, its message; empty if unknown.
std::string UsbOpenHint(const std::string& reason, const std::vector<UsbCameraPlace>& places);

}  // namespace ulf::acquisition
