#include "acquisition/simulator/gige/gvcp_filter.h"

#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <optional>
#include <thread>

#include "acquisition/gige_vision/gvcp.h"

namespace ulf::acquisition {
namespace {

using Clock = std::chrono::steady_clock;

using namespace gvcp;

constexpr std::uint8_t kKey = 0x42, kWantsAnswer = 0x01;
enum Status : std::uint16_t {
  kGood = 0,
  kNotImplemented = 0x8001,
  kInvalidParameter = 0x8002,
  kInvalidAddress = 0x8003,
  kWriteProtect = 0x8004,
  kBadAlignment = 0x8005,
  kAccessDenied = 0x8006,
  kInvalidHeader = 0x800E
};
constexpr std::uint32_t kMostRead = 536;  // bytes of memory in one answer, as the standard has it
constexpr std::uint32_t kControlPrivilege = 0x0A00, kHeartbeatTimeout = 0x0938;
constexpr std::chrono::seconds kPatience(3);  // wait for Aravis, which answers between two frames; guessed
constexpr int kStopCheckMs = 100;             // the thread checks so often whether it is to stop; guessed

using Buffer = std::array<std::uint8_t, 2048>;  // more than any request that is answered

// A request in the receive buffer, with a checked header.
struct Request {
  const std::uint8_t* bytes;
  std::size_t size;

  std::uint16_t Command() const { return Half(bytes + 2); }
  std::uint16_t Number() const { return Half(bytes + 6); }
  const std::uint8_t* Body() const { return bytes + kHeaderBytes; }
  std::size_t BodySize() const { return size - kHeaderBytes; }
  bool Writes() const { return Command() == kWriteRegister || Command() == kWriteMemory; }
  // The following need a well-formed request.
  bool AsksForControl() const { return Writes() && Word(Body()) == kControlPrivilege && BodySize() == 8; }
  bool WritesTo(std::uint32_t address) const {
    const std::size_t bytes_written = BodySize() - 4;
    return Writes() && Word(Body()) <= address && address < Word(Body()) + bytes_written;
  }
};

}  // namespace

struct GvcpFilter::State {
  explicit State(GvcpFilterOptions o) : options(std::move(o)), thread([this] { Run(); }) {}
  ~State() {
    stopping = true;
    thread.join();
    for (const int socket : options.broadcasts) close(socket);
    close(options.unicast);
    close(options.camera);
  }

  void Run();
  void Receive(int socket);
  void Answer(int socket, const sockaddr_in& client, const Request& request);
  Status Check(const Request& request, const sockaddr_in& client);
  void Announce(const Request& request) const;
  Status CheckRange(std::uint32_t address, std::size_t bytes) const;
  Status CheckWrite(std::uint32_t address, std::uint32_t value) const;
  Status CheckWrites(const Request& request) const;
  bool IsController(const sockaddr_in& client) const {
    return controller && controller->sin_port == client.sin_port &&
           controller->sin_addr.s_addr == client.sin_addr.s_addr;
  }
  bool AnotherControls(const sockaddr_in& client);
  // Fills `answer` with Aravis's answer; returns its size, 0: none.
  std::size_t AskCamera(const Request& request);

  const GvcpFilterOptions options;
  std::atomic<std::uint64_t> refused{0};
  std::atomic<bool> stopping{false};
  // Used by the thread alone.
  std::optional<sockaddr_in> controller;
  Buffer incoming{}, answer{};
  std::thread thread;
};

void GvcpFilter::State::Run() {
  std::vector<pollfd> waits{{options.unicast, POLLIN, 0}};
  for (const int socket : options.broadcasts) waits.push_back({socket, POLLIN, 0});
  while (!stopping) {
    if (poll(waits.data(), waits.size(), kStopCheckMs) < 1) continue;
    for (const pollfd& ready : waits)
      if (ready.revents != 0) Receive(ready.fd);
  }
}

void GvcpFilter::State::Receive(int socket) {
  sockaddr_in client{};
  socklen_t size = sizeof client;
  // A longer packet is truncated, and then refused because its length differs from its header's.
  const ssize_t got = recvfrom(socket, incoming.data(), incoming.size(), MSG_DONTWAIT,
                               reinterpret_cast<sockaddr*>(&client), &size);
  if (got < static_cast<ssize_t>(kHeaderBytes) || incoming[0] != kKey) return;
  Answer(socket, client, {incoming.data(), static_cast<std::size_t>(got)});
}

void GvcpFilter::State::Answer(int socket, const sockaddr_in& client, const Request& request) {
  const bool by_broadcast = socket != options.unicast;
  const auto send = [&](std::size_t size) {
    sendto(socket, answer.data(), size, 0, reinterpret_cast<const sockaddr*>(&client), sizeof client);
  };
  const auto begin = [&](std::uint16_t status, std::size_t body) {
    PutHalf(&answer[0], status);
    PutHalf(&answer[2], request.Command() + 1u);
    PutHalf(&answer[4], static_cast<std::uint32_t>(body));
    PutHalf(&answer[6], request.Number());
    return kHeaderBytes + body;
  };
  if (const Status status = Check(request, client);
      status != kGood || (by_broadcast && request.Command() != kDiscovery)) {
    ++refused;
    if (!by_broadcast && (request.bytes[1] & kWantsAnswer) != 0) send(begin(status, 0));
    return;
  }
  // Aravis takes any client's read of this register for the controller's heartbeat, so that a silent
  // controller would keep the camera. The filter answers other clients itself.
  if (request.Command() == kReadRegister && Word(request.Body()) == kControlPrivilege &&
      AnotherControls(client)) {
    PutWord(&answer[kHeaderBytes], options.privilege());
    return send(begin(kGood, 4));
  }
  if (options.before) Announce(request);
  const std::size_t size = AskCamera(request);
  if (size == 0) return;
  if (request.WritesTo(kControlPrivilege)) {
    controller.reset();
    if (options.privilege() != 0) controller = client;
  }
  send(size);
}

Status GvcpFilter::State::Check(const Request& request, const sockaddr_in& client) {
  if (Half(request.bytes + 4) != request.BodySize()) return kInvalidHeader;
  switch (request.Command()) {
    case kDiscovery:
      return request.BodySize() == 0 ? kGood : kInvalidHeader;
    case kReadRegister:
      if (request.BodySize() < 4 || request.BodySize() % 4 != 0) return kInvalidHeader;
      return request.BodySize() == 4 ? CheckRange(Word(request.Body()), 4) : kNotImplemented;
    case kReadMemory: {
      if (request.BodySize() != 8) return kInvalidHeader;
      const std::uint32_t count = Word(request.Body() + 4);
      if (count < 1 || count > kMostRead) return kInvalidParameter;
      return CheckRange(Word(request.Body()), count);
    }
    case kWriteRegister:
      if (request.BodySize() < 8 || request.BodySize() % 8 != 0) return kInvalidHeader;
      if (request.BodySize() > 8) return kNotImplemented;
      break;
    case kWriteMemory:
      if (request.BodySize() < 8 || request.BodySize() % 4 != 0) return kInvalidHeader;
      if (request.BodySize() - 4 > kMostRead) return kInvalidParameter;
      break;
    default:
      return kNotImplemented;
  }
  if (const Status status = CheckWrites(request); status != kGood) return status;
  if (AnotherControls(client)) return kAccessDenied;
  const bool controls = IsController(client) && options.privilege() != 0;
  return controls || request.AsksForControl() ? kGood : kAccessDenied;
}

void GvcpFilter::State::Announce(const Request& request) const {
  if (request.Command() == kDiscovery) return;
  const std::uint32_t address = Word(request.Body());
  if (request.Writes())
    for (std::size_t at = 4; at + 4 <= request.BodySize(); at += 4)
      options.before({address + static_cast<std::uint32_t>(at) - 4, Word(request.Body() + at)});
  else
    options.before({address, std::nullopt});
}

Status GvcpFilter::State::CheckRange(std::uint32_t address, std::size_t bytes) const {
  if (address % 4 != 0) return kBadAlignment;
  return std::uint64_t{address} + bytes <= options.memory_bytes ? kGood : kInvalidAddress;
}

Status GvcpFilter::State::CheckWrite(std::uint32_t address, std::uint32_t value) const {
  const auto found = std::find_if(options.writable.begin(), options.writable.end(),
                                  [&](const WritableRegister& known) { return known.address == address; });
  if (found == options.writable.end()) return kWriteProtect;
  return found->takes(value) ? kGood : kInvalidParameter;
}

Status GvcpFilter::State::CheckWrites(const Request& request) const {
  const std::uint32_t address = Word(request.Body());
  if (const Status status = CheckRange(address, request.BodySize() - 4); status != kGood) return status;
  for (std::size_t at = 4; at < request.BodySize(); at += 4)
    if (const Status status =
            CheckWrite(address + static_cast<std::uint32_t>(at) - 4, Word(request.Body() + at));
        status != kGood)
      return status;
  return kGood;
}

// A controller that sends no heartbeat loses the camera. Aravis checks that only at the next request, so this
// function sends one that changes nothing.
bool GvcpFilter::State::AnotherControls(const sockaddr_in& client) {
  if (IsController(client) || options.privilege() == 0) return false;
  std::array<std::uint8_t, 12> read{kKey, kWantsAnswer, 0, kReadRegister, 0, 4, 0xFF, 0xFF};
  PutWord(&read[kHeaderBytes], kHeartbeatTimeout);
  AskCamera({read.data(), read.size()});
  return options.privilege() != 0;
}

std::size_t GvcpFilter::State::AskCamera(const Request& request) {
  while (recv(options.camera, answer.data(), answer.size(), MSG_DONTWAIT) > 0)
    continue;  // discards late answers to earlier requests
  if (::send(options.camera, request.bytes, request.size, 0) < 0) return 0;
  const auto give_up = Clock::now() + kPatience;
  while (!stopping && Clock::now() < give_up) {
    pollfd wait{options.camera, POLLIN, 0};
    if (poll(&wait, 1, kStopCheckMs) != 1) continue;
    const ssize_t size = recv(options.camera, answer.data(), answer.size(), MSG_DONTWAIT);
    if (size >= static_cast<ssize_t>(kHeaderBytes) && Half(&answer[2]) == request.Command() + 1 &&
        Half(&answer[6]) == request.Number())
      return static_cast<std::size_t>(size);
  }
  return 0;
}

GvcpFilter::GvcpFilter(GvcpFilterOptions options) : state_(std::make_unique<State>(std::move(options))) {}
GvcpFilter::~GvcpFilter() = default;
std::uint64_t GvcpFilter::Refused() const { return state_->refused; }

}  // namespace ulf::acquisition
