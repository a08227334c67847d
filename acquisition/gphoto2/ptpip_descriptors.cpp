#include "acquisition/gphoto2/ptpip_descriptors.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>

namespace ulf {
KeepsDescriptorZero::KeepsDescriptorZero() : saved_(fcntl(0, F_DUPFD_CLOEXEC, 3)) {}

KeepsDescriptorZero::~KeepsDescriptorZero() {
  if (saved_ < 0) return;
  if (fcntl(0, F_GETFD) < 0)
    if (const int again = fcntl(saved_, F_DUPFD, 0); again > 0) close(again);
  close(saved_);
}

std::vector<int> ConnectionsTo(const std::string& host, int port) {
  std::vector<int> found;
  std::error_code ignored;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd", ignored)) {
    const int descriptor = std::atoi(entry.path().filename().c_str());
    sockaddr_in peer{};
    socklen_t length = sizeof peer;
    if (getpeername(descriptor, reinterpret_cast<sockaddr*>(&peer), &length) != 0) continue;
    char address[INET_ADDRSTRLEN] = "";
    if (peer.sin_family != AF_INET || !inet_ntop(AF_INET, &peer.sin_addr, address, sizeof address)) continue;
    if (host == address && ntohs(peer.sin_port) == port) found.push_back(descriptor);
  }
  return found;
}

PtpipDescriptors::PtpipDescriptors(const std::string& port) : is_ptpip_(port.starts_with("ptpip:")) {
  if (!is_ptpip_) return;
  const std::size_t first = port.find(':') + 1, second = port.find(':', first);
  host_ = port.substr(first, second - first);
  port_ = second == std::string::npos ? 15740 : std::atoi(port.c_str() + second + 1);
  // Something is to stand there that may be closed.
  if (fcntl(0, F_GETFD) < 0)
    if (const int null = open("/dev/null", O_RDONLY); null > 0) close(null);
  struct stat zero {};
  fstat(0, &zero);
  device_ = zero.st_dev;
  inode_ = zero.st_ino;
  before_ = ConnectionsTo(host_, port_);
}

void PtpipDescriptors::Opened() {
  if (!is_ptpip_) return;
  for (const int descriptor : ConnectionsTo(host_, port_))
    if (std::find(before_.begin(), before_.end(), descriptor) == before_.end())
      connections_.push_back(descriptor);
}

void PtpipDescriptors::Close(const std::function<void()>& close_camera) {
  if (!is_ptpip_) return close_camera();
  struct stat zero {};
  const bool as_it_was = fstat(0, &zero) == 0 && zero.st_dev == device_ && zero.st_ino == inode_;
  if (as_it_was) {
    const KeepsDescriptorZero keeps;
    close_camera();
  }
  // Those that are still the camera's: a connection that broke may have been closed, its number used again.
  for (const int descriptor : ConnectionsTo(host_, port_))
    if (std::find(connections_.begin(), connections_.end(), descriptor) != connections_.end())
      close(descriptor);
}

}  // namespace ulf
