// Lists the UDP sockets of this process that are bound to an IPv4 address. The camera library does not give
// access to its sockets, so they are found by address and port.
#pragma once

#include <netinet/in.h>

#include <vector>

namespace ulf::acquisition {

struct BoundSocket {
  int fd = -1;
  sockaddr_in at{};

  int Port() const { return ntohs(at.sin_port); }
};

std::vector<BoundSocket> BoundUdpSockets();

// Returns the sockets that are not in `before`.
std::vector<BoundSocket> BoundSince(const std::vector<BoundSocket>& before);

}  // namespace ulf::acquisition
