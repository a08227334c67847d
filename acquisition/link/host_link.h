// Reads the computer's limits for cameras from the kernel, /proc and /sys: the network interface that leads
// to a camera, receive buffers, memory for USB. aravis_usb.h tells where a USB camera is plugged in.
#pragma once

#include <optional>
#include <string>

namespace ulf::acquisition {

struct NetworkLink {
  std::string interface;
  int mtu = 0;                             // bytes; 0: not known
  std::optional<double> bytes_per_s = {};  // of the wire; none: unknown, as of a virtual interface
};

// Returns the link on the kernel's route to an IPv4 address; none where there is no route.
std::optional<NetworkLink> NetworkLinkTo(const std::string& address);

// Returns usbfs_memory_mb, how many megabytes all programs together may have in transit to and from USB
// devices; 0 if there is no limit, none if the system does not tell.
std::optional<int> UsbMemoryMb();

// Returns net.core.rmem_max, the largest receive buffer of a socket that a program may request, in bytes;
// none where the system does not tell.
std::optional<double> MostSocketBuffer();

}  // namespace ulf::acquisition
