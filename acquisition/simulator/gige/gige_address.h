// Gives addresses to simulated GigE Vision cameras. GVCP has one fixed UDP port, so every camera needs its
// own IPv4 address; the loopback network has enough of them.
#pragma once

#include <cstdint>
#include <string>

#include "core/base/file_descriptor.h"

namespace ulf::acquisition {

// Opens a UDP socket that is bound to address:port (0: any free port) and does not block. Throws Refusal if
// `address` is no IPv4 address, Error if it is not one of this machine or another program uses the port.
FileDescriptor OpenUdpSocket(const std::string& address, int port);
std::uint16_t PortOf(const FileDescriptor& bound_socket);

// Adds an address of the loopback network (127.x.x.x) to the interface as long as the object lives; does
// nothing for any other address, or one that is there. Of the addresses that killed simulators left, it takes
// over this one and removes the others.
class LoopbackAddress {
 public:
  // Throws Error, with the command to run, when the address is missing and may not be added.
  explicit LoopbackAddress(const std::string& address);
  ~LoopbackAddress();
  LoopbackAddress(const LoopbackAddress&) = delete;
  LoopbackAddress& operator=(const LoopbackAddress&) = delete;

 private:
  std::string label_;     // of the added address; empty: none was added
  FileDescriptor claim_;  // a lock that ends with the process
};

// Returns the camera's own address when a relay uses `address`: 127.(a+64).b.c for 127.a.b.c. Throws Refusal
// for an address outside 127.0.0.0/10.
std::string HiddenGigeAddress(const std::string& address);

}  // namespace ulf::acquisition
