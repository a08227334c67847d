#include "acquisition/link/host_link.h"

#include <arpa/inet.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <netinet/in.h>
#include <sys/ioctl.h>
#include <sys/socket.h>

#include <cstring>
#include <filesystem>
#include <fstream>

#include "core/base/file_descriptor.h"

namespace ulf::acquisition {
namespace {

namespace fs = std::filesystem;

template <typename Value>
std::optional<Value> FirstOf(const fs::path& file) {
  std::ifstream stream(file);
  Value value{};
  if (stream >> value) return value;
  return std::nullopt;
}

// Returns the local address from which the kernel would send there.
std::optional<in_addr> LocalAddressFor(const std::string& address) {
  sockaddr_in to{}, from{};
  to.sin_family = AF_INET;
  to.sin_port = htons(3956);  // any port: nothing is sent
  if (inet_pton(AF_INET, address.c_str(), &to.sin_addr) != 1) return std::nullopt;
  const FileDescriptor asking(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  if (!asking.IsOpen()) return std::nullopt;
  socklen_t size = sizeof from;
  const bool routed = connect(asking.Number(), reinterpret_cast<sockaddr*>(&to), sizeof to) == 0 &&
                      getsockname(asking.Number(), reinterpret_cast<sockaddr*>(&from), &size) == 0;
  return routed ? std::optional(from.sin_addr) : std::nullopt;
}

std::string InterfaceWith(const in_addr& address) {
  ifaddrs* all = nullptr;
  if (getifaddrs(&all) != 0) return "";
  std::string name;
  for (const ifaddrs* each = all; each && name.empty(); each = each->ifa_next)
    if (each->ifa_addr && each->ifa_addr->sa_family == AF_INET &&
        reinterpret_cast<const sockaddr_in*>(each->ifa_addr)->sin_addr.s_addr == address.s_addr)
      name = each->ifa_name;
  freeifaddrs(all);
  return name;
}

// Asked of the kernel: /sys may show the interfaces of another network namespace.
int MtuOf(const std::string& interface) {
  ifreq request{};
  std::strncpy(request.ifr_name, interface.c_str(), sizeof request.ifr_name - 1);
  const FileDescriptor asking(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  if (!asking.IsOpen()) return 0;
  const bool known = ioctl(asking.Number(), SIOCGIFMTU, &request) == 0;
  return known ? request.ifr_mtu : 0;
}

}  // namespace

std::optional<NetworkLink> NetworkLinkTo(const std::string& address) {
  const auto local = LocalAddressFor(address);
  if (!local) return std::nullopt;
  NetworkLink link{.interface = InterfaceWith(*local)};
  if (link.interface.empty()) return std::nullopt;
  const fs::path folder = fs::path("/sys/class/net") / link.interface;
  link.mtu = MtuOf(link.interface);
  // Megabits; -1 or an error where there is no wire.
  constexpr double kBytesPerMegabit = 1e6 / 8;
  if (const auto speed = FirstOf<double>(folder / "speed"); speed && *speed > 0)
    link.bytes_per_s = kBytesPerMegabit * *speed;
  return link;
}

std::optional<int> UsbMemoryMb() { return FirstOf<int>("/sys/module/usbcore/parameters/usbfs_memory_mb"); }

std::optional<double> MostSocketBuffer() { return FirstOf<double>("/proc/sys/net/core/rmem_max"); }

}  // namespace ulf::acquisition
