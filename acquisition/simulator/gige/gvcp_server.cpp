#include "acquisition/simulator/gige/gvcp_server.h"

#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <utility>

#include "acquisition/gige_vision/gige_vision_probe.h"
#include "acquisition/gige_vision/gvcp.h"
#include "acquisition/simulator/gige/gige_address.h"

namespace ulf::acquisition {

using namespace gvcp;

namespace {

constexpr std::uint8_t kKey = 0x42, kWantsAnswer = 0x01;
constexpr std::uint32_t kMostRead = 536;  // bytes of memory in one answer, as the standard has it

// A socket that several cameras of a machine bind to the same broadcast address; not open: there is none.
FileDescriptor SharedBroadcastSocket(std::uint32_t broadcast_address) {
  FileDescriptor shared(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  const int yes = 1;
  setsockopt(shared.Number(), SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  const sockaddr_in at = SocketAddress(broadcast_address, kGvcpPort);
  if (bind(shared.Number(), reinterpret_cast<const sockaddr*>(&at), sizeof at) != 0) return {};
  return shared;
}

}  // namespace

enum GvcpServer::Status : std::uint16_t {
  kGood = 0,
  kNotImplemented = 0x8001,
  kInvalidParameter = 0x8002,
  kInvalidAddress = 0x8003,
  kWriteProtect = 0x8004,
  kBadAlignment = 0x8005,
  kAccessDenied = 0x8006,
  kInvalidHeader = 0x800E
};

// A request with a header.
struct GvcpServer::Request {
  std::span<const std::uint8_t> bytes;

  bool WantsAnswer() const { return (bytes[1] & kWantsAnswer) != 0; }
  std::uint16_t Command() const { return Half(&bytes[2]); }
  std::uint16_t Number() const { return Half(&bytes[6]); }
  const std::uint8_t* Body() const { return bytes.data() + kHeaderBytes; }
  std::size_t BodySize() const { return bytes.size() - kHeaderBytes; }
  bool Writes() const { return Command() == kWriteRegister || Command() == kWriteMemory; }
  // The following need a well-formed request.
  std::uint32_t Address() const { return Word(Body()); }
  bool AsksForControl() const { return Writes() && Address() == kControlPrivilegeAt && BodySize() == 8; }
  // Calls `use(address, value)` for every register that is written.
  template <typename Use>
  void ForEachWritten(Use use) const {
    for (std::size_t at = 4; at + 4 <= BodySize(); at += 4)
      use(Address() + static_cast<std::uint32_t>(at) - 4, Word(Body() + at));
  }
};

GvcpServer::GvcpServer(RegisterMemory& memory, std::vector<WritableRegister> writable,
                       std::function<void(const GvcpAccess&)> before)
    : memory_(memory), writable_(std::move(writable)), before_(std::move(before)) {}

void GvcpServer::Listen(const std::string& address) {
  sockets_.push_back(OpenUdpSocket(address, kGvcpPort));
  const auto listen_also = [&](std::uint32_t broadcast_address) {
    if (FileDescriptor shared = SharedBroadcastSocket(broadcast_address); shared.IsOpen())
      sockets_.push_back(std::move(shared));
  };
  listen_also(INADDR_BROADCAST);
  for (const NetworkInterface& interface : NetworkInterfaces())
    if (interface.address == address && !interface.loopback)
      listen_also(Ipv4(address).value_or(0) | ~Ipv4(interface.netmask).value_or(0));
}

void GvcpServer::AnswerUntil(std::chrono::system_clock::time_point end) {
  std::vector<pollfd> waits;
  for (const FileDescriptor& socket : sockets_) waits.push_back({socket.Number(), POLLIN, 0});
  const std::chrono::nanoseconds wait = end - std::chrono::system_clock::now();
  const auto left = std::max<std::int64_t>(0, wait.count());
  const timespec patience{left / 1'000'000'000, left % 1'000'000'000};
  EndSilentControl();
  if (ppoll(waits.data(), waits.size(), &patience, nullptr) < 1) return;
  for (const pollfd& ready : waits) {
    if (ready.revents == 0) continue;
    sockaddr_in client{};
    socklen_t size = sizeof client;
    // A longer packet is truncated, and then refused because its length differs from its header's.
    const ssize_t got = recvfrom(ready.fd, incoming_.data(), incoming_.size(), MSG_DONTWAIT,
                                 reinterpret_cast<sockaddr*>(&client), &size);
    if (got < 0) continue;
    const auto answer = Answer({incoming_.data(), static_cast<std::size_t>(got)}, client,
                               ready.fd != sockets_.front().Number());
    if (!answer.empty())
      sendto(ready.fd, answer.data(), answer.size(), 0, reinterpret_cast<const sockaddr*>(&client),
             sizeof client);
  }
}

std::span<const std::uint8_t> GvcpServer::Answer(std::span<const std::uint8_t> packet,
                                                 const sockaddr_in& client, bool by_broadcast) {
  answer_.clear();
  if (packet.size() < kHeaderBytes || packet[0] != kKey) return answer_;
  EndSilentControl();
  const Request request{packet};
  const Status status = Check(request, client);
  if (status != kGood || (by_broadcast && request.Command() != kDiscovery)) {
    ++refused_;
    if (!by_broadcast && request.WantsAnswer()) BeginAnswer(request, status, 0);
    return answer_;
  }
  if (before_) Announce(request);
  CarryOut(request, client);
  return answer_;
}

std::span<std::uint8_t> GvcpServer::BeginAnswer(const Request& request, Status status,
                                                std::size_t body_bytes) {
  answer_.resize(kHeaderBytes + body_bytes);
  PutHalf(&answer_[0], status);
  PutHalf(&answer_[2], request.Command() + 1u);
  PutHalf(&answer_[4], static_cast<std::uint32_t>(body_bytes));
  PutHalf(&answer_[6], request.Number());
  return std::span(answer_).subspan(kHeaderBytes);
}

void GvcpServer::CarryOut(const Request& request, const sockaddr_in& client) {
  switch (request.Command()) {
    case kDiscovery:
      return memory_.Read(0, BeginAnswer(request, kGood, kDiscoveryBytes));
    case kReadRegister:
      if (request.Address() == kControlPrivilegeAt && IsController(client))
        last_heartbeat_ = std::chrono::steady_clock::now();
      return memory_.Read(request.Address(), BeginAnswer(request, kGood, 4));
    case kReadMemory: {
      const auto body = BeginAnswer(request, kGood, 4 + Word(request.Body() + 4));
      PutWord(body.data(), request.Address());
      return memory_.Read(request.Address(), body.subspan(4));
    }
    default:
      request.ForEachWritten([&](std::uint32_t address, std::uint32_t value) {
        memory_.Write(address, value);
        if (address != kControlPrivilegeAt) return;
        controller_.reset();
        if (value != 0) controller_ = client;
        last_heartbeat_ = std::chrono::steady_clock::now();
      });
      // Aravis's cameras answer so; clients look at the status alone.
      PutWord(BeginAnswer(request, kGood, 4).data(),
              request.Command() == kWriteRegister ? 1 : request.Address());
  }
}

GvcpServer::Status GvcpServer::Check(const Request& request, const sockaddr_in& client) const {
  if (Half(&request.bytes[4]) != request.BodySize()) return kInvalidHeader;
  switch (request.Command()) {
    case kDiscovery:
      return request.BodySize() == 0 ? kGood : kInvalidHeader;
    case kReadRegister:
      if (request.BodySize() < 4 || request.BodySize() % 4 != 0) return kInvalidHeader;
      return request.BodySize() == 4 ? CheckRange(request.Address(), 4) : kNotImplemented;
    case kReadMemory: {
      if (request.BodySize() != 8) return kInvalidHeader;
      const std::uint32_t count = Word(request.Body() + 4);
      if (count < 1 || count > kMostRead) return kInvalidParameter;
      return CheckRange(request.Address(), count);
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
  const bool may_write = IsControlled() ? IsController(client) : request.AsksForControl();
  return may_write ? kGood : kAccessDenied;
}

void GvcpServer::Announce(const Request& request) const {
  if (request.Command() == kDiscovery) return;
  if (request.Writes())
    request.ForEachWritten([&](std::uint32_t address, std::uint32_t value) { before_({address, value}); });
  else
    before_({request.Address(), std::nullopt});
}

GvcpServer::Status GvcpServer::CheckRange(std::uint32_t address, std::size_t bytes) const {
  if (address % 4 != 0) return kBadAlignment;
  return std::uint64_t{address} + bytes <= memory_.Bytes() ? kGood : kInvalidAddress;
}

GvcpServer::Status GvcpServer::CheckWrite(std::uint32_t address, std::uint32_t value) const {
  const auto found = std::find_if(writable_.begin(), writable_.end(),
                                  [&](const WritableRegister& known) { return known.address == address; });
  if (found == writable_.end()) return kWriteProtect;
  return found->takes(value) ? kGood : kInvalidParameter;
}

GvcpServer::Status GvcpServer::CheckWrites(const Request& request) const {
  Status status = CheckRange(request.Address(), request.BodySize() - 4);
  if (status != kGood) return status;
  request.ForEachWritten([&](std::uint32_t address, std::uint32_t value) {
    if (status == kGood) status = CheckWrite(address, value);
  });
  return status;
}

bool GvcpServer::IsController(const sockaddr_in& client) const {
  return controller_ && controller_->sin_port == client.sin_port &&
         controller_->sin_addr.s_addr == client.sin_addr.s_addr;
}

void GvcpServer::EndSilentControl() {
  const std::chrono::milliseconds timeout(memory_.Read(kHeartbeatTimeoutAt));
  if (!controller_ || std::chrono::steady_clock::now() - last_heartbeat_ <= timeout) return;
  controller_.reset();
  memory_.Write(kControlPrivilegeAt, 0u);
}

}  // namespace ulf::acquisition
