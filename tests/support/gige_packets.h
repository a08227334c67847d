// Makes packets of GigE Vision, correct and false ones, and sends them, also under false addresses. Use it in
// a network namespace of the test's own only (EnterLoopbackNamespace() of own_namespaces.h).
#pragma once

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/gige_vision/gige_vision_probe.h"
#include "core/base/error.h"
#include "tests/support/floors.h"

namespace ulf::test {

using Packet = std::vector<std::uint8_t>;

// Appends the low `bytes` bytes of a value, big-endian.
inline void Append(Packet& packet, std::uint64_t value, int bytes) {
  for (int i = bytes - 1; i >= 0; --i) packet.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
}

inline Packet Words(std::initializer_list<std::uint32_t> words) {
  Packet packet;
  for (const std::uint32_t word : words) Append(packet, word, 4);
  return packet;
}

// ---- control

struct ControlRequest {
  std::uint16_t command;
  Packet body = {};
  std::optional<std::uint16_t> length = {};  // what its header says; none: the true length
  std::uint8_t key = 0x42, flags = 0x01;
};

inline Packet Control(const ControlRequest& request, std::uint16_t number = 7) {
  Packet packet{request.key, request.flags};
  Append(packet, request.command, 2);
  Append(packet, request.length.value_or(static_cast<std::uint16_t>(request.body.size())), 2);
  Append(packet, number, 2);
  packet.insert(packet.end(), request.body.begin(), request.body.end());
  return packet;
}

// ---- stream: kinds 1 leader, 2 trailer, 3 payload, 4 all in one, 5 H.264, 7 of several parts

// Both return a packet of the stream: with a plain header, or with extended ids (64-bit frame ids).
inline Packet Plain(int kind, std::uint16_t frame, std::uint32_t number, const Packet& body = {}) {
  Packet packet;
  Append(packet, 0, 2);
  Append(packet, frame, 2);
  Append(packet, static_cast<std::uint32_t>(kind) << 24 | number, 4);
  packet.insert(packet.end(), body.begin(), body.end());
  return packet;
}

inline Packet Extended(int kind, std::uint64_t frame, std::uint32_t number, const Packet& body = {}) {
  Packet packet;
  Append(packet, 0, 4);
  Append(packet, 0x80000000u | static_cast<std::uint32_t>(kind) << 24, 4);
  Append(packet, frame, 8);
  Append(packet, number, 4);
  packet.insert(packet.end(), body.begin(), body.end());
  return packet;
}

inline Packet Leader(std::uint32_t width, std::uint32_t height, std::uint32_t format = 0x01080001,
                     std::uint32_t type = 1) {
  return Words({type, 0, 0, format, width, height, 0, 0, 0});
}

// Returns the leader of a frame of several parts, each of so many bytes.
inline Packet MultipartLeader(int parts, std::uint64_t bytes_each) {
  Packet body = Words({10, 0, 0});
  for (int i = 0; i < parts; ++i) {
    Append(body, 1, 2);
    Append(body, bytes_each, 6);
    body.resize(body.size() + 40);
  }
  return body;
}

// ---- ways

class UdpSocket {
 public:
  // Port 0: any.
  explicit UdpSocket(const std::string& address = "127.0.0.1", int port = 0)
      : fd_(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
    const sockaddr_in at = At(address, port);
    if (bind(fd_, reinterpret_cast<const sockaddr*>(&at), sizeof at) != 0)
      throw Error("{}:{} cannot be had", address, port);
  }
  ~UdpSocket() { close(fd_); }
  UdpSocket(const UdpSocket&) = delete;
  UdpSocket& operator=(const UdpSocket&) = delete;

  static sockaddr_in At(const std::string& address, int port) {
    sockaddr_in at{};
    at.sin_family = AF_INET;
    at.sin_port = htons(static_cast<std::uint16_t>(port));
    inet_pton(AF_INET, address.c_str(), &at.sin_addr);
    return at;
  }
  int fd() const { return fd_; }
  int Port() const {
    sockaddr_in at{};
    socklen_t size = sizeof at;
    getsockname(fd_, reinterpret_cast<sockaddr*>(&at), &size);
    return ntohs(at.sin_port);
  }
  void Send(const Packet& packet, const std::string& address, int port) const {
    const sockaddr_in to = At(address, port);
    sendto(fd_, packet.data(), packet.size(), 0, reinterpret_cast<const sockaddr*>(&to), sizeof to);
  }
  std::optional<Packet> Receive(int patience_ms) const {
    pollfd wait{fd_, POLLIN, 0};
    if (poll(&wait, 1, patience_ms) != 1) return std::nullopt;
    Packet packet(65536);
    const ssize_t size = recv(fd_, packet.data(), packet.size(), 0);
    if (size < 0) return std::nullopt;
    packet.resize(static_cast<std::size_t>(size));
    return packet;
  }

 private:
  int fd_;
};

// Sends as if from any address and port, as whoever is root on the same network can.
class Forger {
 public:
  Forger() : fd_(socket(AF_INET, SOCK_RAW | SOCK_CLOEXEC, IPPROTO_RAW)) {
    if (fd_ < 0) throw Error("no raw socket");
  }
  ~Forger() { close(fd_); }
  Forger(const Forger&) = delete;
  Forger& operator=(const Forger&) = delete;

  void Send(const Packet& packet, const sockaddr_in& from, const sockaddr_in& to) const {
    const std::size_t size = 28 + packet.size();
    Packet bytes;
    Append(bytes, 0x4500, 2);
    Append(bytes, size, 2);
    Append(bytes, 0, 4);
    Append(bytes, 64, 1);
    Append(bytes, IPPROTO_UDP, 1);
    Append(bytes, 0, 2);  // the kernel's
    Append(bytes, ntohl(from.sin_addr.s_addr), 4);
    Append(bytes, ntohl(to.sin_addr.s_addr), 4);
    Append(bytes, ntohs(from.sin_port), 2);
    Append(bytes, ntohs(to.sin_port), 2);
    Append(bytes, 8 + packet.size(), 2);
    Append(bytes, 0, 2);  // none
    bytes.insert(bytes.end(), packet.begin(), packet.end());
    sendto(fd_, bytes.data(), bytes.size(), 0, reinterpret_cast<const sockaddr*>(&to), sizeof to);
  }

 private:
  int fd_;
};

// From where and to where a camera sends its stream, as it tells everybody who asks.
struct StreamEnds {
  sockaddr_in from, to;
};
inline StreamEnds AskStreamEnds(const std::string& camera) {
  const auto word = [&](std::uint32_t at) { return ReadGigeRegister(camera, at).value_or(0); };
  StreamEnds ends{UdpSocket::At(camera, static_cast<int>(word(0xD1C) & 0xFFFF)),
                  UdpSocket::At("0.0.0.0", static_cast<int>(word(0xD00) & 0xFFFF))};
  ends.to.sin_addr.s_addr = htonl(word(0xD18));
  return ends;
}

}  // namespace ulf::test
