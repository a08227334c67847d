#include "acquisition/simulator/gige_discovery.h"

#include <arpa/inet.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cstring>

namespace ulf {
namespace {

// GigE Vision's control protocol: a header of eight bytes, then for a discovery answer the first 248 bytes of
// the bootstrap registers, in which the serial number stands at 0xd8.
constexpr std::array<unsigned char, 8> kDiscover{0x42, 0x01, 0x00, 0x02, 0x00, 0x00, 0x00, 0x2A};
constexpr std::size_t kHeaderBytes = 8, kSerialAt = 0xd8, kSerialBytes = 16;

}  // namespace

std::optional<std::string> SerialOfGigeCamera(const std::string& address, std::chrono::milliseconds timeout) {
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_port = htons(kGvcpPort);
  if (inet_pton(AF_INET, address.c_str(), &to.sin_addr) != 1) return std::nullopt;
  const int socket_fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (socket_fd < 0) return std::nullopt;
  std::optional<std::string> serial;
  if (sendto(socket_fd, kDiscover.data(), kDiscover.size(), 0, reinterpret_cast<const sockaddr*>(&to),
             sizeof(to)) == static_cast<ssize_t>(kDiscover.size())) {
    pollfd wait{socket_fd, POLLIN, 0};
    std::array<char, 1024> answer{};
    if (poll(&wait, 1, static_cast<int>(timeout.count())) > 0) {
      const ssize_t size = recv(socket_fd, answer.data(), answer.size(), 0);
      if (size >= static_cast<ssize_t>(kHeaderBytes + kSerialAt + kSerialBytes)) {
        const char* text = answer.data() + kHeaderBytes + kSerialAt;
        serial = std::string(text, strnlen(text, kSerialBytes));
      }
    }
  }
  close(socket_fd);
  return serial;
}

}  // namespace ulf
