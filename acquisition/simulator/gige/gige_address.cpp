#include "acquisition/simulator/gige/gige_address.h"

#include <net/if.h>
#include <netinet/in.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "acquisition/gige_vision/gige_vision_probe.h"
#include "core/base/error.h"

namespace ulf::acquisition {
namespace {

bool IsLoopback(std::uint32_t address) { return address >> 24 == 127; }

// 0, or the error number.
int AddAlias(const std::string& label, std::uint32_t address) {
  const FileDescriptor asking(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  if (!asking.IsOpen()) return errno;
  ifreq request{};
  std::strncpy(request.ifr_name, label.c_str(), IFNAMSIZ - 1);
  const sockaddr_in at = SocketAddress(address, 0);
  std::memcpy(&request.ifr_addr, &at, sizeof(at));
  return ioctl(asking.Number(), SIOCSIFADDR, &request) == 0 ? 0 : errno;
}

void RemoveAlias(const std::string& label) {
  const FileDescriptor asking(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  if (!asking.IsOpen()) return;
  ifreq request{};
  std::strncpy(request.ifr_name, label.c_str(), IFNAMSIZ - 1);
  if (ioctl(asking.Number(), SIOCGIFFLAGS, &request) == 0) {
    request.ifr_flags =
        static_cast<short>(request.ifr_flags & ~IFF_UP);  // the kernel removes an alias that is down
    ioctl(asking.Number(), SIOCSIFFLAGS, &request);
  }
}

// Reserves the label for this process until it ends, also by a signal; not open: another process has it.
FileDescriptor Claim(const std::string& label) {
  FileDescriptor claim(socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  if (!claim.IsOpen()) return {};
  sockaddr_un name{};
  name.sun_family = AF_UNIX;
  const std::string text =
      "ulf loopback address " + label;  // after a zero byte: an abstract name, not a file
  text.copy(name.sun_path + 1, sizeof(name.sun_path) - 1);
  const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + text.size());
  if (bind(claim.Number(), reinterpret_cast<const sockaddr*>(&name), size) != 0) return {};
  return claim;
}

constexpr char kLabelPrefix[] = "lo:ulf";

}  // namespace

FileDescriptor OpenUdpSocket(const std::string& address, int port) {
  const auto number = Ipv4(address);
  if (!number)
    throw Refusal("", address, fmt::format("'{}' is not an IPv4 address such as 127.0.0.1", address), "");
  const sockaddr_in at = SocketAddress(*number, port);
  FileDescriptor opened(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (bind(opened.Number(), reinterpret_cast<const sockaddr*>(&at), sizeof(at)) == 0) return opened;
  const int failed = errno;
  if (failed == EADDRNOTAVAIL)
    throw Error("{} is not an address of this machine; give one of its own ('ip addr' lists them)", address);
  if (failed == EADDRINUSE) {
    const auto camera = QueryGigeCamera(address);
    throw Error("{}:{} is taken by {}; stop it, or serve on another address, for example 127.0.0.2", address,
                port,
                camera ? "a GigE Vision camera with serial '" + camera->serial + "'" : "another program");
  }
  throw Error("{}:{} cannot be opened: {}", address, port, std::strerror(failed));
}

std::uint16_t PortOf(const FileDescriptor& bound_socket) {
  sockaddr_in at{};
  socklen_t size = sizeof(at);
  getsockname(bound_socket.Number(), reinterpret_cast<sockaddr*>(&at), &size);
  return ntohs(at.sin_port);
}

LoopbackAddress::LoopbackAddress(const std::string& address) {
  const auto number = Ipv4(address);
  if (!number || !IsLoopback(*number)) return;
  // A label has at most 15 characters; the three lower bytes identify the address.
  const std::string label = fmt::format("{}{:06x}", kLabelPrefix, *number & 0xFFFFFF);
  bool is_there = false;
  for (const NetworkInterface& interface : NetworkInterfaces()) {
    is_there = is_there || interface.address == address;
    if (!interface.name.starts_with(kLabelPrefix)) continue;
    FileDescriptor claim = Claim(interface.name);
    if (!claim.IsOpen()) continue;  // another process uses it
    if (interface.name == label) {
      claim_ = std::move(claim);
      label_ = label;
    } else {
      RemoveAlias(interface.name);
    }
  }
  if (is_there) return;
  claim_ = Claim(label);
  if (const int failed = AddAlias(label, *number))
    throw Error(
        "a simulated camera needs the address {} on the loopback interface, and it could not be added ({}); "
        "run 'sudo ip addr add {}/8 dev lo' once, or use a private network: unshare -rn",
        address, std::strerror(failed), address);
  label_ = label;
}

LoopbackAddress::~LoopbackAddress() {
  if (!label_.empty()) RemoveAlias(label_);
}

std::string HiddenGigeAddress(const std::string& address) {
  const auto number = Ipv4(address);
  if (!number || (*number & 0xFFC00000u) != 0x7F000000u)
    throw Refusal(address, "",
                  "link faults can be simulated at loopback addresses only, 127.0.0.1 to 127.63.255.254", "");
  const std::uint32_t hidden = *number + (64u << 16);
  return fmt::format("127.{}.{}.{}", hidden >> 16 & 255, hidden >> 8 & 255, hidden & 255);
}

}  // namespace ulf::acquisition
