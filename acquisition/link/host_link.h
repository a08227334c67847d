// What this computer says of the way to a camera: the network interface that leads to an address, or the USB port that
// a device hangs on. Reads /proc and /sys and changes nothing.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace ulf::acquisition {

struct NetworkLink {
  std::string interface;
  int mtu = 0;                        // bytes; 0: not known
  std::optional<double> bytes_per_s;  // of the wire; none: the system does not tell (a virtual interface)
  std::optional<std::uint64_t> most_receive_buffer;  // net.core.rmem_max, bytes
};

// The way to an IPv4 address as the kernel routes it; none where there is no route.
std::optional<NetworkLink> NetworkLinkTo(const std::string& address);

struct UsbLink {
  std::string port;               // of the system, such as 2-1.4
  double megabits_per_s = 0;      // as negotiated: 480, 5000, 10000
  std::optional<int> buffers_mb;  // usbfs_memory_mb: what all programs may have in flight; 0: no limit
};

// The port of the device with this serial number below `sys` (the root of sysfs, for tests); none where none has it.
std::optional<UsbLink> UsbLinkOf(const std::string& serial, const std::string& sys = "/sys");

}  // namespace ulf::acquisition
