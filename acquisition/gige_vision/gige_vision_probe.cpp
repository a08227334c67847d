#include "acquisition/gige_vision/gige_vision_probe.h"

#include <arpa/inet.h>
#include <fmt/core.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <thread>

#include "acquisition/gige_vision/gvcp.h"
#include "core/base/file_descriptor.h"

namespace ulf::acquisition {

using namespace gvcp;

namespace {

using std::chrono::milliseconds;
using Clock = std::chrono::steady_clock;

FileDescriptor UdpSocket() { return FileDescriptor(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)); }

constexpr milliseconds kRefusedPause(10);  // before a refused request is sent again; guessed

std::optional<sockaddr_in> GvcpPortOf(const std::string& ipv4_address) {
  const auto address = Ipv4(ipv4_address);
  if (!address) return std::nullopt;
  return SocketAddress(*address, kGvcpPort);
}

std::string AddressText(std::uint32_t host_order) {
  return fmt::format("{}.{}.{}.{}", host_order >> 24, host_order >> 16 & 0xFF, host_order >> 8 & 0xFF,
                     host_order & 0xFF);
}

std::uint32_t AddressNumber(const std::string& text) { return Ipv4(text).value_or(0); }

// Key, flags (acknowledge, the answer may be broadcast), DISCOVERY, no payload, request id.
constexpr std::array<std::uint8_t, 8> kDiscover{0x42, 0x11, 0x00, 0x02, 0x00, 0x00, 0x00, 0x2A};

std::optional<GigeAnswer> ReceiveGigeAnswer(int socket) {
  std::array<std::uint8_t, 1024> bytes{};
  const ssize_t size = recv(socket, bytes.data(), bytes.size(), 0);
  return size < 0 ? std::nullopt : ReadGigeAnswer({bytes.data(), static_cast<std::size_t>(size)});
}

}  // namespace

std::optional<std::uint32_t> Ipv4(const std::string& text) {
  in_addr parsed{};
  if (inet_pton(AF_INET, text.c_str(), &parsed) != 1) return std::nullopt;
  return ntohl(parsed.s_addr);
}

sockaddr_in SocketAddress(std::uint32_t ipv4, int port) {
  sockaddr_in at{};
  at.sin_family = AF_INET;
  at.sin_port = htons(static_cast<std::uint16_t>(port));
  at.sin_addr.s_addr = htonl(ipv4);
  return at;
}

std::optional<GigeAnswer> ReadGigeAnswer(std::span<const std::uint8_t> packet) {
  if (packet.size() < kHeaderBytes + kDiscoveryBytes || Half(&packet[2]) != kDiscoveryAck)
    return std::nullopt;
  const std::uint8_t* registers = packet.data() + kHeaderBytes;
  const auto address = [&](std::size_t at) { return AddressText(Word(registers + at)); };
  const auto text = [&](std::size_t at, std::size_t length) {
    const char* begin = reinterpret_cast<const char*>(registers + at);
    return std::string(begin, strnlen(begin, length));
  };
  return GigeAnswer{.address = address(kCurrentAddressAt),
                    .netmask = address(kNetmaskAt),
                    .maker = text(kMakerAt, 32),
                    .model = text(kModelAt, 32),
                    .serial = text(kSerialAt, 16)};
}

std::optional<std::uint32_t> ReadGigeRegister(const std::string& ipv4_address, std::uint32_t register_address,
                                              milliseconds timeout) {
  const auto camera = GvcpPortOf(ipv4_address);
  const FileDescriptor socket = UdpSocket();
  if (!camera || !socket.IsOpen() ||
      connect(socket.Number(), reinterpret_cast<const sockaddr*>(&*camera), sizeof(*camera)) != 0)
    return std::nullopt;
  // Key, "acknowledge", READREG, four bytes of payload, request id, register address; all big-endian.
  std::array<std::uint8_t, 12> request = {0x42, 0x01, 0x00, 0x80, 0x00, 0x04, 0xCA, 0x11};
  PutWord(&request[kHeaderBytes], register_address);
  for (int attempt = 0; attempt < 2; ++attempt) {
    const auto give_up = Clock::now() + timeout;
    if (send(socket.Number(), request.data(), request.size(), 0) < 0) {
      // The previous request was refused: the address exists, but nothing listens there (yet).
      std::this_thread::sleep_for(kRefusedPause);
      continue;
    }
    pollfd waiting{socket.Number(), POLLIN, 0};
    for (;;) {
      const auto left = std::chrono::duration_cast<milliseconds>(give_up - Clock::now()).count();
      if (left < 0 || poll(&waiting, 1, static_cast<int>(left)) != 1) break;
      // Status, READREG acknowledged, length, request id, value.
      std::array<std::uint8_t, 64> answer{};
      const ssize_t size = recv(socket.Number(), answer.data(), answer.size(), 0);
      if (size < 0) break;
      const bool is_ours =
          size >= 8 && answer[2] == 0x00 && answer[3] == 0x81 && answer[6] == 0xCA && answer[7] == 0x11;
      if (!is_ours) continue;
      if (size < 12 || answer[0] != 0 || answer[1] != 0) return std::nullopt;
      return Word(&answer[kHeaderBytes]);
    }
  }
  return std::nullopt;
}

GigeControl QueryGigeControl(const std::string& ipv4_address, milliseconds timeout) {
  const auto privilege = ReadGigeRegister(ipv4_address, kControlPrivilegeAt, timeout);
  if (!privilege) return GigeControl::kNoAnswer;
  return *privilege & 0x03 ? GigeControl::kControlled : GigeControl::kFree;  // exclusive or shared control
}

std::string QueryGigeController(const std::string& ipv4_address) {
  const std::uint32_t address = ReadGigeRegister(ipv4_address, kControllerAddressAt).value_or(0);
  if (address == 0) return "";
  const std::uint32_t port = ReadGigeRegister(ipv4_address, kControllerPortAt).value_or(0) & 0xFFFF;
  std::string text = AddressText(address);
  for (const NetworkInterface& own : NetworkInterfaces())
    if (own.address == text) text += ", this computer";
  return port == 0 ? text : fmt::format("{} (UDP port {})", text, port);
}

std::optional<GigeAnswer> QueryGigeCamera(const std::string& ipv4_address, milliseconds timeout) {
  const auto camera = GvcpPortOf(ipv4_address);
  const FileDescriptor socket = UdpSocket();
  if (!camera || !socket.IsOpen() ||
      sendto(socket.Number(), kDiscover.data(), kDiscover.size(), 0,
             reinterpret_cast<const sockaddr*>(&*camera), sizeof(*camera)) < 0)
    return std::nullopt;
  pollfd waiting{socket.Number(), POLLIN, 0};
  if (poll(&waiting, 1, static_cast<int>(timeout.count())) != 1) return std::nullopt;
  return ReceiveGigeAnswer(socket.Number());
}

std::vector<GigeAnswer> DiscoverGigeCameras(milliseconds timeout) {
  std::vector<FileDescriptor> sockets;
  std::vector<pollfd> waiting;
  for (const NetworkInterface& interface : NetworkInterfaces()) {
    FileDescriptor socket = UdpSocket();
    const sockaddr_in own = SocketAddress(AddressNumber(interface.address), 0);
    const int yes = 1;
    setsockopt(socket.Number(), SOL_SOCKET, SO_BROADCAST, &yes, sizeof(yes));
    if (bind(socket.Number(), reinterpret_cast<const sockaddr*>(&own), sizeof(own)) != 0) continue;
    // Sends through this interface, whatever the routes are.
    setsockopt(socket.Number(), SOL_SOCKET, SO_BINDTODEVICE, interface.name.c_str(),
               static_cast<socklen_t>(interface.name.size() + 1));
    const std::uint32_t mask = AddressNumber(interface.netmask);
    for (const std::uint32_t to : {0xFFFFFFFFu, AddressNumber(interface.address) | ~mask}) {
      const sockaddr_in everyone = SocketAddress(to, kGvcpPort);
      sendto(socket.Number(), kDiscover.data(), kDiscover.size(), 0,
             reinterpret_cast<const sockaddr*>(&everyone), sizeof everyone);
    }
    waiting.push_back({socket.Number(), POLLIN, 0});
    sockets.push_back(std::move(socket));
  }
  std::vector<GigeAnswer> found;
  const auto give_up = Clock::now() + timeout;
  for (;;) {
    const auto left = std::chrono::duration_cast<milliseconds>(give_up - Clock::now()).count();
    if (left < 0 || poll(waiting.data(), waiting.size(), static_cast<int>(left)) < 1) break;
    for (const pollfd& ready : waiting) {
      if (!(ready.revents & POLLIN)) continue;
      const auto answer = ReceiveGigeAnswer(ready.fd);
      const bool known = !answer || std::any_of(found.begin(), found.end(), [&](const GigeAnswer& other) {
        return other.address == answer->address && other.serial == answer->serial;
      });
      if (!known) found.push_back(*answer);
    }
  }
  return found;
}

std::vector<NetworkInterface> NetworkInterfaces() {
  std::vector<NetworkInterface> interfaces;
  ifaddrs* list = nullptr;
  if (getifaddrs(&list) != 0) return interfaces;
  for (const ifaddrs* entry = list; entry; entry = entry->ifa_next) {
    if (!entry->ifa_addr || !entry->ifa_netmask || entry->ifa_addr->sa_family != AF_INET ||
        !(entry->ifa_flags & IFF_UP))
      continue;
    const auto number = [](const sockaddr* address) {
      return ntohl(reinterpret_cast<const sockaddr_in*>(address)->sin_addr.s_addr);
    };
    interfaces.push_back({.name = entry->ifa_name,
                          .address = AddressText(number(entry->ifa_addr)),
                          .netmask = AddressText(number(entry->ifa_netmask)),
                          .loopback = (entry->ifa_flags & IFF_LOOPBACK) != 0});
  }
  freeifaddrs(list);
  return interfaces;
}

std::string WrongNetworkText(const GigeAnswer& camera, const std::vector<NetworkInterface>& interfaces) {
  const std::uint32_t camera_address = AddressNumber(camera.address);
  std::string own;
  for (const NetworkInterface& interface : interfaces) {
    const std::uint32_t mask = AddressNumber(interface.netmask);
    if ((AddressNumber(interface.address) & mask) == (camera_address & mask)) return "";
    if (!interface.loopback)
      own += fmt::format("{}{} has {} mask {}", own.empty() ? "" : ", ", interface.name, interface.address,
                         interface.netmask);
  }
  return fmt::format(
      "wrong network: the camera has the address {}{}, this computer {}. Give one of them an address in the "
      "network of the other",
      camera.address, camera.netmask == "0.0.0.0" ? "" : " mask " + camera.netmask,
      own.empty() ? "has no network address" : "is in another network: " + own);
}

}  // namespace ulf::acquisition
