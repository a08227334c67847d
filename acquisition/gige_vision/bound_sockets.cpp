#include "acquisition/gige_vision/bound_sockets.h"

#include <sys/socket.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>

namespace ulf::acquisition {

std::vector<BoundSocket> BoundUdpSockets() {
  std::vector<BoundSocket> found;
  std::error_code error;
  for (std::filesystem::directory_iterator entry("/proc/self/fd", error), end; !error && entry != end;
       entry.increment(error)) {
    BoundSocket socket{.fd = std::atoi(entry->path().filename().c_str())};
    socklen_t size = sizeof socket.at;
    int type = 0;
    socklen_t type_size = sizeof type;
    if (getsockname(socket.fd, reinterpret_cast<sockaddr*>(&socket.at), &size) == 0 &&
        socket.at.sin_family == AF_INET && socket.at.sin_port != 0 &&
        getsockopt(socket.fd, SOL_SOCKET, SO_TYPE, &type, &type_size) == 0 && type == SOCK_DGRAM)
      found.push_back(socket);
  }
  return found;
}

std::vector<BoundSocket> BoundSince(const std::vector<BoundSocket>& before) {
  std::vector<BoundSocket> now = BoundUdpSockets();
  std::erase_if(now, [&](const BoundSocket& socket) {
    return std::any_of(before.begin(), before.end(), [&](const BoundSocket& old) {
      return old.fd == socket.fd && old.at.sin_port == socket.at.sin_port &&
             old.at.sin_addr.s_addr == socket.at.sin_addr.s_addr;
    });
  });
  return now;
}

}  // namespace ulf::acquisition
