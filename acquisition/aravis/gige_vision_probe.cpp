#include "acquisition/aravis/gige_vision_probe.h"

#include <arpa/inet.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cstdint>
#include <set>

namespace ulf {
namespace {

constexpr std::uint16_t kGvcpPort = 3956;
constexpr std::uint32_t kControlChannelPrivilege = 0x0A00;

struct Socket {
  int fd = -1;
  ~Socket() {
    if (fd >= 0) close(fd);
  }
};

}  // namespace

GigeControl AskGigeControl(const std::string& ipv4_address, std::chrono::milliseconds timeout) {
  sockaddr_in camera{};
  camera.sin_family = AF_INET;
  camera.sin_port = htons(kGvcpPort);
  if (inet_pton(AF_INET, ipv4_address.c_str(), &camera.sin_addr) != 1) return GigeControl::kNoAnswer;
  const Socket socket{::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)};
  if (socket.fd < 0 || connect(socket.fd, reinterpret_cast<sockaddr*>(&camera), sizeof(camera)) != 0)
    return GigeControl::kNoAnswer;

  // Key, "acknowledge", READREG, four bytes of payload, request id, register address; all big-endian.
  constexpr std::array<std::uint8_t, 12> kRequest = {
      0x42, 0x01, 0x00, 0x80, 0x00, 0x04, 0xCA, 0x11, 0x00, 0x00, kControlChannelPrivilege >> 8, 0x00};
  for (int attempt = 0; attempt < 2; ++attempt) {
    if (send(socket.fd, kRequest.data(), kRequest.size(), 0) < 0) continue;
    pollfd waiting{socket.fd, POLLIN, 0};
    if (poll(&waiting, 1, static_cast<int>(timeout.count())) != 1) continue;
    // Status, READREG acknowledged, length, request id, value.
    std::array<std::uint8_t, 64> answer{};
    const ssize_t size = recv(socket.fd, answer.data(), answer.size(), 0);
    const bool is_ours =
        size >= 12 && answer[2] == 0x00 && answer[3] == 0x81 && answer[6] == 0xCA && answer[7] == 0x11;
    if (!is_ours) continue;
    const bool controlled = (answer[11] & 0x03) != 0;  // exclusive access or control access
    return controlled ? GigeControl::kControlled : GigeControl::kFree;
  }
  return GigeControl::kNoAnswer;
}

bool PacketSocketWouldMishear(const std::string& camera_ipv4_address) {
  in_addr camera{};
  if (inet_pton(AF_INET, camera_ipv4_address.c_str(), &camera) != 1) return true;
  if ((ntohl(camera.s_addr) >> 24) == 127) return true;
  ifaddrs* list = nullptr;
  if (getifaddrs(&list) != 0) return true;
  std::set<std::string> networks;
  bool is_own_address = false;
  for (const ifaddrs* entry = list; entry; entry = entry->ifa_next) {
    if (!entry->ifa_addr || entry->ifa_addr->sa_family != AF_INET) continue;
    if (reinterpret_cast<const sockaddr_in*>(entry->ifa_addr)->sin_addr.s_addr == camera.s_addr)
      is_own_address = true;
    if ((entry->ifa_flags & IFF_UP) && !(entry->ifa_flags & IFF_LOOPBACK)) networks.insert(entry->ifa_name);
  }
  freeifaddrs(list);
  return is_own_address || networks.size() > 1;
}

}  // namespace ulf
