// The UDP sockets of this process that are bound to an IPv4 address. The camera library keeps its own to
// itself; they are known by their address and port.
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

// Those that were not there before.
std::vector<BoundSocket> BoundSince(const std::vector<BoundSocket>& before);

}  // namespace ulf::acquisition
