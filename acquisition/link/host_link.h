// Reads from the kernel, /proc and /sys, without changing anything, the network interface that leads to a
// camera, and its limits. (Where a USB camera is plugged in: aravis_usb.h.)
#pragma once

#include <optional>
#include <string>

namespace ulf::acquisition {

struct NetworkLink {
  std::string interface;
  int mtu = 0;  // bytes; 0: not known
  std::optional<double> bytes_per_s =
      {};  // of the wire; none: the system does not tell (a virtual interface)
};

// Returns the link on the kernel's route to an IPv4 address; none where there is no route.
std::optional<NetworkLink> NetworkLinkTo(const std::string& address);

// Returns usbfs_memory_mb, what all programs together may have in flight to and from USB devices; 0: no
// limit; none where the system does not tell.
std::optional<int> UsbMemoryMb();

// Returns net.core.rmem_max, the largest receive buffer of a socket that a program may request, in bytes;
// none where the system does not tell.
std::optional<double> MostSocketBuffer();

}  // namespace ulf::acquisition
