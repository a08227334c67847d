// Defines one connection of the emulated camera, which sends and reads packets of PTP/IP on a socket. Only
// ptpip_camera.cpp includes it.
#pragma once

#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "tests/support/floors.h"
#include "tests/support/ptp_wire.h"
#include "tests/support/ptpip_camera.h"

namespace ulf::test {

using namespace ptp;

struct PtpipCamera::Request {
  std::uint16_t operation = 0;
  std::uint32_t transaction = 0;
  std::vector<std::uint32_t> parameters;
  std::string data;  // sent with it

  std::uint32_t Parameter(std::size_t i) const { return i < parameters.size() ? parameters[i] : 0; }
};

class PtpipCamera::Connection {
 public:
  explicit Connection(int socket) : socket_(socket) {}
  ~Connection() { close(socket_); }
  void Shutdown() { shutdown(socket_, SHUT_RDWR); }

  // Returns false when the other side is gone, or a packet has an impossible length.
  bool Read(std::uint32_t& type, std::string& payload) {
    std::string head(8, 0);
    if (!ReadBytes(head)) return false;
    const auto length = Get<std::uint32_t>(head, 0);
    type = Get<std::uint32_t>(head, 4);
    if (length < 8 || length > (64u << 20)) return false;
    payload.assign(length - 8, 0);
    return ReadBytes(payload);
  }

  bool Send(std::uint32_t type, const std::string& payload) {
    std::string packet;
    Put<std::uint32_t>(packet, static_cast<std::uint32_t>(payload.size() + 8));
    Put<std::uint32_t>(packet, type);
    packet += payload;
    const std::lock_guard lock(mutex_);
    for (std::size_t sent = 0; sent < packet.size();) {
      const ssize_t n = send(socket_, packet.data() + sent, packet.size() - sent, MSG_NOSIGNAL);
      if (n <= 0) return false;
      sent += static_cast<std::size_t>(n);
    }
    return true;
  }

  void Respond(const Request& request, std::uint16_t code) {
    std::string payload;
    Put(payload, code);
    Put(payload, request.transaction);
    Send(kResponse, payload);
  }

  // `bytes_per_s`: 0: no limit.
  void SendData(const Request& request, const std::string& data, double bytes_per_s = 0) {
    std::string payload;
    Put(payload, request.transaction);
    Put<std::uint64_t>(payload, data.size());
    if (!Send(kStartData, payload)) return;
    constexpr std::size_t kPiece = 64 << 10;
    for (std::size_t at = 0;; at += kPiece) {
      const bool last = at + kPiece >= data.size();
      payload.clear();
      Put(payload, request.transaction);
      payload += data.substr(std::min(at, data.size()), kPiece);
      if (!Send(last ? kEndData : kData, payload)) return;
      if (bytes_per_s > 0)
        std::this_thread::sleep_for(std::chrono::duration<double>(
            static_cast<double>(std::min(kPiece, data.size() - std::min(at, data.size()))) / bytes_per_s));
      if (last) return;
    }
  }

 private:
  bool ReadBytes(std::string& into) {
    for (std::size_t got = 0; got < into.size();) {
      const ssize_t n = recv(socket_, into.data() + got, into.size() - got, 0);
      if (n <= 0) return false;
      got += static_cast<std::size_t>(n);
    }
    return true;
  }

  int socket_;
  std::mutex mutex_;
};

}  // namespace ulf::test
