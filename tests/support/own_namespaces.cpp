#include "tests/support/own_namespaces.h"

#include <fcntl.h>
#include <fmt/core.h>
#include <net/if.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <sys/mount.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>
#include <opencv2/core/utility.hpp>
#include <vector>

namespace ulf::test {

std::optional<std::string> MountSmallDisk(const std::filesystem::path& folder, std::uint64_t bytes) {
  const uid_t uid = getuid();
  const gid_t gid = getgid();
  if (unshare(CLONE_NEWNS) != 0) {
    if (unshare(CLONE_NEWUSER | CLONE_NEWNS) != 0)
      return fmt::format("no mount namespace of our own: {}", std::strerror(errno));
    std::ofstream("/proc/self/setgroups") << "deny";
    std::ofstream("/proc/self/uid_map") << "0 " << uid << " 1";
    std::ofstream("/proc/self/gid_map") << "0 " << gid << " 1";
  }
  // Threads that run already stay in the namespace before and do not see the disk. In a process of many
  // tests these are OpenCV's, which is told to use none.
  const auto tasks = std::filesystem::directory_iterator("/proc/self/task");
  if (std::distance(begin(tasks), end(tasks)) > 1) cv::setNumThreads(1);
  const std::string size = fmt::format("size={}", bytes);
  if (mount(nullptr, "/", nullptr, MS_REC | MS_PRIVATE, nullptr) != 0 ||
      mount("tmpfs", folder.c_str(), "tmpfs", 0, size.c_str()) != 0)
    return fmt::format("no disk of our own can be mounted: {}", std::strerror(errno));
  return std::nullopt;
}

void FillDisk(const std::filesystem::path& file) {
  const int descriptor = open(file.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
  const std::vector<char> block(4096, 'x');
  while (write(descriptor, block.data(), block.size()) > 0) {
  }
  close(descriptor);
}

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
