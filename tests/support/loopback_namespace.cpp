#include "tests/support/loopback_namespace.h"

#include <fmt/core.h>
#include <net/if.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>

namespace ulf::test {

std::optional<std::string> EnterLoopbackNamespace() {
  const uid_t uid = getuid();
  const gid_t gid = getgid();
  if (unshare(CLONE_NEWNET) != 0) {
    if (unshare(CLONE_NEWUSER | CLONE_NEWNET) != 0)
      return fmt::format("no network namespace of our own: {}", std::strerror(errno));
    std::ofstream("/proc/self/setgroups") << "deny";
    std::ofstream("/proc/self/uid_map") << "0 " << uid << " 1";
    std::ofstream("/proc/self/gid_map") << "0 " << gid << " 1";
  }
  const int socket_fd = socket(AF_INET, SOCK_DGRAM, 0);
  ifreq request{};
  std::strcpy(request.ifr_name, "lo");
  const bool up = socket_fd >= 0 && ioctl(socket_fd, SIOCGIFFLAGS, &request) == 0 &&
                  (request.ifr_flags |= IFF_UP | IFF_RUNNING, ioctl(socket_fd, SIOCSIFFLAGS, &request) == 0);
  const int reason = errno;
  if (socket_fd >= 0) close(socket_fd);
  if (!up) return fmt::format("loopback cannot be switched on: {}", std::strerror(reason));
  return std::nullopt;
}

}  // namespace ulf::test
