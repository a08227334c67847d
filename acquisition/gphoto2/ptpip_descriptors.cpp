#include "acquisition/gphoto2/ptpip_descriptors.h"

#include <arpa/inet.h>
#include <sched.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <thread>

namespace ulf::acquisition {
namespace {

unsigned long long InodeOf(int descriptor) {
  struct stat status {};
  return fstat(descriptor, &status) == 0 ? status.st_ino : 0;
}

}  // namespace

std::vector<Connection> ConnectionsTo(const std::string& host, int port) {
  std::vector<Connection> found;
  std::error_code ignored;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd", ignored)) {
    const int descriptor = std::atoi(entry.path().filename().c_str());
    sockaddr_in peer{};
    socklen_t length = sizeof peer;
    if (getpeername(descriptor, reinterpret_cast<sockaddr*>(&peer), &length) != 0) continue;
    char address[INET_ADDRSTRLEN] = "";
    if (peer.sin_family != AF_INET || !inet_ntop(AF_INET, &peer.sin_addr, address, sizeof address)) continue;
    if (host == address && ntohs(peer.sin_port) == port) found.push_back({descriptor, InodeOf(descriptor)});
  }
  return found;
}

bool RunWithOwnDescriptors(const std::function<void()>& function) {
  bool ran = false;
  std::thread apart([&] {
    if (unshare(CLONE_FILES) != 0) return;
    function();
    ran = true;
  });
  apart.join();
  return ran;
}

PtpipDescriptors::PtpipDescriptors(const std::string& port) : is_ptpip_(port.starts_with("ptpip:")) {
  if (!is_ptpip_) return;
  const std::size_t first = port.find(':') + 1, second = port.find(':', first);
  host_ = port.substr(first, second - first);
  port_ = second == std::string::npos ? 15740 : std::atoi(port.c_str() + second + 1);
  before_ = ConnectionsTo(host_, port_);
}

void PtpipDescriptors::Opened() {
  if (!is_ptpip_) return;
  for (const Connection& connection : ConnectionsTo(host_, port_))
    if (std::find(before_.begin(), before_.end(), connection) == before_.end())
      connections_.push_back(connection);
}

void PtpipDescriptors::Close(const std::function<void()>& close_camera) {
  if (!is_ptpip_) return close_camera();
  RunWithOwnDescriptors(close_camera);  // where the system does not allow it, only the library's memory leaks
  for (const Connection& connection : connections_)
    if (InodeOf(connection.descriptor) == connection.inode) close(connection.descriptor);
}

}  // namespace ulf::acquisition
