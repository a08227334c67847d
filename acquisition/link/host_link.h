// What this computer says of the way to a camera: the network interface that leads to an address, and its
// limits. Asks the kernel, reads /proc and /sys and changes nothing. (Where a USB camera is plugged in:
// aravis_usb.h.)
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

// The way to an IPv4 address as the kernel routes it; none where there is no route.
std::optional<NetworkLink> NetworkLinkTo(const std::string& address);

// usbfs_memory_mb: what all programs together may have in flight to and from USB devices; 0: no limit. None
// where the system does not tell.
std::optional<int> UsbMemoryMb();

// net.core.rmem_max: the most that a program may ask of a socket's receive buffer, in bytes. None where the
// system does not tell.
std::optional<double> MostSocketBuffer();

}  // namespace ulf::acquisition
