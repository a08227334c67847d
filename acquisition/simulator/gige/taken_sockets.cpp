#include "acquisition/simulator/gige/taken_sockets.h"

#include <arpa/inet.h>
#include <sys/socket.h>
#include <unistd.h>

#include <fcntl.h>
#include <cerrno>
#include <cstring>

#include "acquisition/gige_vision/gige_vision_probe.h"
#include "core/base/error.h"

namespace ulf::acquisition {
namespace {

void CheckSocketCall(int result) {
  if (result < 0) throw Error("there is no socket for the simulated camera: {}", std::strerror(errno));
}

int NewSocket() {
  const int fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  CheckSocketCall(fd);
  return fd;
}

// Two sockets that are connected to each other.
std::pair<int, int> ConnectedPair() {
  const int ends[2] = {NewSocket(), NewSocket()};
  sockaddr_in at[2] = {};
  for (int i = 0; i < 2; ++i) {
    at[i].sin_family = AF_INET;
    at[i].sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof at[i];
    CheckSocketCall(bind(ends[i], reinterpret_cast<sockaddr*>(&at[i]), size));
    CheckSocketCall(getsockname(ends[i], reinterpret_cast<sockaddr*>(&at[i]), &size));
  }
  for (int i = 0; i < 2; ++i)
    CheckSocketCall(connect(ends[i], reinterpret_cast<sockaddr*>(&at[1 - i]), sizeof at[0]));
  return {ends[0], ends[1]};
}

// Makes the descriptor number `library_fd` refer to the socket `instead`; returns a new descriptor of its old
// socket.
int Replace(int library_fd, int instead) {
  const int taken = fcntl(library_fd, F_DUPFD_CLOEXEC, 0);
  dup3(instead, library_fd, O_CLOEXEC);
  close(instead);
  return taken;
}

}  // namespace

TakenSockets TakeControlSockets(const std::vector<BoundSocket>& before, const std::string& address) {
  in_addr own{};
  inet_pton(AF_INET, address.c_str(), &own);
  TakenSockets taken;
  for (const BoundSocket& socket : BoundSince(before)) {
    const bool at_camera = socket.at.sin_addr.s_addr == own.s_addr;
    if (socket.Port() == kGvcpPort && at_camera) {
      const auto [library_fd, filter_fd] = ConnectedPair();
      taken.to_library = filter_fd;
      taken.unicast = Replace(socket.fd, library_fd);
    } else if (socket.Port() == kGvcpPort) {
      taken.broadcasts.push_back(Replace(socket.fd, NewSocket()));
    } else if (at_camera) {
      taken.stream_port = socket.Port();
      taken.stream = fcntl(socket.fd, F_DUPFD_CLOEXEC, 0);
      CheckSocketCall(taken.stream);
    }
  }
  return taken;
}

}  // namespace ulf::acquisition
