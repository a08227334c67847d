// Answers the control requests (GVCP, GigE Vision 2.x) that reach the simulated camera: discovery, reads and
// writes of its memory. It answers a request that it does not carry out with the protocol's status codes:
//
//   NOT_IMPLEMENTED    an unknown command, or several registers in one request
//   INVALID_HEADER     a length that differs from the packet's
//   INVALID_PARAMETER  a count of zero or of more than an answer holds, a value out of the register's range
//   INVALID_ADDRESS    an address beyond registers and description
//   BAD_ALIGNMENT      an address that is not a multiple of four
//   WRITE_PROTECT      a read-only register
//   ACCESS_DENIED      a write by a client without control of the camera, except the request for control
//                      while no other client has it
//
// It ignores packets that are no GVCP requests, and invalid ones that want no answer or came by broadcast.
//
// A client controls the camera from its write of the control channel privilege until it writes 0 there, or
// until it has not read that register (its heartbeat) for longer than the heartbeat time-out.
#pragma once

#include <netinet/in.h>

#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "acquisition/simulator/gige/register_memory.h"
#include "core/base/file_descriptor.h"

namespace ulf::acquisition {

// A register of four bytes at `address` that accepts values for which `takes` is true.
struct WritableRegister {
  std::uint32_t address;
  std::function<bool(std::uint32_t)> takes;
};

// A register that a valid request reads or writes; `written`: its new value.
struct GvcpAccess {
  std::uint32_t address = 0;
  std::optional<std::uint32_t> written;
};

// Only one thread may call it; any thread may call Refused().
class GvcpServer {
 public:
  // `before` is called before a valid request reads or writes. `memory` must outlive this object.
  GvcpServer(RegisterMemory& memory, std::vector<WritableRegister> writable,
             std::function<void(const GvcpAccess&)> before = {});

  // Opens the sockets: address:3956 and, for discovery, broadcast addresses. Throws as OpenUdpSocket() does.
  void Listen(const std::string& address);
  // Waits for requests, at most until `end`, and answers those that came. Ends the control of a client that
  // was silent for too long.
  void AnswerUntil(std::chrono::system_clock::time_point end);
  // Returns the answer to one packet, valid until the next call; empty: no answer is to be sent.
  std::span<const std::uint8_t> Answer(std::span<const std::uint8_t> packet, const sockaddr_in& client,
                                       bool by_broadcast);
  bool IsControlled() const { return controller_.has_value(); }

  std::uint64_t Refused() const { return refused_; }  // requests that were not carried out

 private:
  struct Request;
  enum Status : std::uint16_t;

  void EndSilentControl();
  Status Check(const Request& request, const sockaddr_in& client) const;
  Status CheckRange(std::uint32_t address, std::size_t bytes) const;
  Status CheckWrite(std::uint32_t address, std::uint32_t value) const;
  Status CheckWrites(const Request& request) const;
  void Announce(const Request& request) const;
  void CarryOut(const Request& request, const sockaddr_in& client);
  // Begins an answer; returns the place of its body.
  std::span<std::uint8_t> BeginAnswer(const Request& request, Status status, std::size_t body_bytes);
  bool IsController(const sockaddr_in& client) const;

  RegisterMemory& memory_;
  const std::vector<WritableRegister> writable_;
  const std::function<void(const GvcpAccess&)> before_;
  std::vector<FileDescriptor> sockets_;  // the first is the unicast one
  std::optional<sockaddr_in> controller_;
  std::chrono::steady_clock::time_point last_heartbeat_;
  std::atomic<std::uint64_t> refused_ = 0;
  std::array<std::uint8_t, 2048> incoming_{};  // more than any request that is carried out
  std::vector<std::uint8_t> answer_;
};

}  // namespace ulf::acquisition
