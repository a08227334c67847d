// Addresses of simulated GigE Vision cameras. GVCP has one fixed UDP port, so every camera needs its own IPv4
// address; the loopback network has enough of them.
#pragma once

#include <cstdint>
#include <string>

#include "core/base/file_descriptor.h"

namespace ulf::acquisition {

// A UDP socket that is bound to address:port (0: any free port) and does not block. Throws Refusal when
// `address` is no IPv4 address, Error when another program uses the port or it is not an address of this
// machine.
FileDescriptor OpenUdpSocket(const std::string& address, int port);
std::uint16_t PortOf(const FileDescriptor& bound_socket);

// Adds an address of the loopback network (127.x.x.x) to the interface for its lifetime. An address that
// exists stays, except those that a killed simulator has left: this one is taken over, and the others are
// removed.
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

// The camera's address when a relay uses `address`: 127.(a+64).b.c for 127.a.b.c. Throws Refusal for an
// address outside 127.0.0.0/10.
std::string HiddenGigeAddress(const std::string& address);

}  // namespace ulf::acquisition
