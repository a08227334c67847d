#include "acquisition/simulator/gige/gige_relay.h"

#include <netinet/in.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <deque>
#include <map>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include "acquisition/gige_vision/gige_vision_probe.h"
#include "acquisition/gige_vision/gvcp.h"
#include "acquisition/simulator/gige/gige_address.h"
#include "acquisition/simulator/gige/gige_registers.h"
#include "core/base/file_descriptor.h"
#include "core/base/mutex.h"

namespace ulf::acquisition {
namespace {

using Clock = std::chrono::steady_clock;
using Bytes = std::vector<std::uint8_t>;

using namespace gvcp;

constexpr std::uint32_t kCapabilityRegister = 0x0934, kResendCapability = 1u << 2;
// GVSP: status (2), frame number (2), kind of packet (1), packet number (3).
constexpr int kLeader = 1, kTrailer = 2;

constexpr std::size_t kFramesKept = 8;     // whose packets can be resent; guessed
constexpr std::size_t kMostClients = 64;   // guessed
constexpr std::size_t kMostBytes = 65536;  // of a UDP packet
// Stream packets read in one round: with more, a fast camera would delay resend requests. Guessed.
constexpr int kPacketsInARound = 64;
constexpr int kReceiveBufferBytes = 32 << 20;  // of the stream's socket; guessed
constexpr std::uint64_t kDecisions = 8;  // room for those that Draw() makes about one attempt of a packet

class Socket {
 public:
  // Bound to address:port (0: any). Throws as OpenUdpSocket() does.
  Socket(const std::string& address, int port) : descriptor_(OpenUdpSocket(address, port)) {}

  int fd() const { return descriptor_.Number(); }
  std::uint16_t Port() const { return PortOf(descriptor_); }

  void SendTo(const sockaddr_in& to, const std::uint8_t* bytes, std::size_t size) const {
    sendto(fd(), bytes, size, 0, reinterpret_cast<const sockaddr*>(&to), sizeof(to));
  }
  // The size of a packet; none: no packet waits.
  std::optional<std::size_t> Receive(Bytes& into, sockaddr_in& from) const {
    socklen_t size = sizeof(from);
    const ssize_t got =
        recvfrom(fd(), into.data(), into.size(), MSG_DONTWAIT, reinterpret_cast<sockaddr*>(&from), &size);
    if (got < 0) return std::nullopt;
    return static_cast<std::size_t>(got);
  }
  void EnlargeReceiveBuffer() const {
    for (const int option : {SO_RCVBUFFORCE, SO_RCVBUF})
      if (setsockopt(fd(), SOL_SOCKET, option, &kReceiveBufferBytes, sizeof(kReceiveBufferBytes)) == 0)
        return;
  }

 private:
  const FileDescriptor descriptor_;
};

// A number from 0 to 1 for one decision about one packet (splitmix64's finisher over its coordinates).
double Draw(std::uint64_t seed, std::uint64_t frame, std::uint64_t packet, std::uint64_t decision) {
  std::uint64_t z = seed * 0x9E3779B97F4A7C15u + (frame << 40 | packet << 8 | decision);
  for (int round = 0; round < 2; ++round) {
    z += 0x9E3779B97F4A7C15u;
    z = (z ^ z >> 30) * 0xBF58476D1CE4E5B9u;
    z = (z ^ z >> 27) * 0x94D049BB133111EBu;
    z ^= z >> 31;
  }
  return static_cast<double>(z >> 11) * 0x1p-53;
}

struct StreamPacket {
  Bytes bytes;
  std::uint64_t times_sent = 0;

  std::uint16_t Frame() const { return Half(&bytes[2]); }
  std::uint32_t Number() const { return Word(&bytes[4]) & 0xFFFFFF; }
  int Kind() const { return bytes[4] & 0x0F; }
};

}  // namespace

struct GigeRelay::State {
  explicit State(const GigeRelayOptions& o)
      : options(o),
        public_control(o.address, kGvcpPort),
        public_stream(o.address, 0),
        camera_stream(o.camera, 0),
        wake(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)),
        camera(SocketAddress(Ipv4(o.camera).value(), kGvcpPort)) {
    camera_stream.EnlargeReceiveBuffer();
    thread = std::thread([this] { Run(); });
  }
  ~State() {
    stopping = true;
    const std::uint64_t one = 1;
    [[maybe_unused]] const auto written = write(wake.Number(), &one, sizeof(one));
    thread.join();
  }

  // The camera distinguishes clients by their source address, so each client has its own socket.
  struct Client {
    explicit Client(const std::string& camera_address, const sockaddr_in& a)
        : address(a), to_camera(camera_address, 0) {}
    sockaddr_in address;
    Socket to_camera;
    // Requests that wait for an answer, by their number: a register whose value the relay changes, and its
    // offset in the answer.
    std::map<std::uint16_t, std::pair<std::uint32_t, std::size_t>> rewritten;
    Clock::time_point last_heard = Clock::now();
  };
  struct KeptFrame {
    std::uint16_t number = 0;
    bool late = false;
    std::map<std::uint32_t, StreamPacket> packets;
  };
  struct Held {
    Clock::time_point until;
    Bytes bytes;
  };

  void Run();
  Client& ClientAt(const sockaddr_in& from);
  void FromClient();
  void FromCamera(Client& client);
  void FromStream();
  void RewriteWrites(std::uint8_t* request, std::size_t size);
  void Resend(const std::uint8_t* request, std::size_t size);
  KeptFrame& FrameOf(std::uint16_t number);
  void Forward(StreamPacket& packet, bool late);
  void Hold(const Bytes& bytes, Clock::time_point until);
  void SendHeld();
  void ToClient(const Bytes& bytes) {
    if (stream_client.sin_port != 0) public_stream.SendTo(stream_client, bytes.data(), bytes.size());
  }

  const GigeRelayOptions options;
  mutable Mutex mutex;
  GigeRelayStatistics statistics ULF_GUARDED_BY(mutex);
  std::atomic<bool> control_passes{true}, stream_passes{true}, stopping{false};

  Socket public_control, public_stream, camera_stream;
  const FileDescriptor wake;
  const sockaddr_in camera;

  // Used by the relay's thread alone.
  sockaddr_in stream_client{};  // port 0: none
  std::vector<std::unique_ptr<Client>> clients;
  std::deque<KeptFrame> kept;
  std::deque<Held> held;
  std::optional<Bytes> swapped;  // to be sent after its successor
  Bytes buffer = Bytes(kMostBytes);
  std::thread thread;
};

void GigeRelay::State::Run() {
  std::vector<pollfd> waits;
  while (!stopping) {
    waits = {{wake.Number(), POLLIN, 0}, {public_control.fd(), POLLIN, 0}, {camera_stream.fd(), POLLIN, 0}};
    for (const auto& client : clients) waits.push_back({client->to_camera.fd(), POLLIN, 0});
    timespec patience{1, 0};
    if (!held.empty()) {
      const auto left = std::max(Clock::duration::zero(), held.front().until - Clock::now());
      const auto ns = std::chrono::duration_cast<std::chrono::nanoseconds>(left).count();
      patience = {ns / 1'000'000'000, ns % 1'000'000'000};
    }
    if (ppoll(waits.data(), waits.size(), &patience, nullptr) < 0 && errno != EINTR) return;
    for (std::size_t i = 3; i < waits.size(); ++i)
      if (waits[i].revents != 0) FromCamera(*clients[i - 3]);
    if (waits[2].revents != 0) FromStream();
    if (waits[1].revents != 0) FromClient();
    SendHeld();
  }
}

GigeRelay::State::Client& GigeRelay::State::ClientAt(const sockaddr_in& from) {
  for (const auto& client : clients)
    if (client->address.sin_port == from.sin_port &&
        client->address.sin_addr.s_addr == from.sin_addr.s_addr) {
      client->last_heard = Clock::now();
      return *client;
    }
  if (clients.size() >= kMostClients)
    clients.erase(std::min_element(clients.begin(), clients.end(), [](const auto& a, const auto& b) {
      return a->last_heard < b->last_heard;
    }));
  return *clients.emplace_back(std::make_unique<Client>(options.camera, from));
}

void GigeRelay::State::FromClient() {
  sockaddr_in from{};
  while (const auto size = public_control.Receive(buffer, from)) {
    if (*size < kHeaderBytes || !control_passes) continue;
    const std::uint16_t command = Half(&buffer[2]), request = Half(&buffer[6]);
    if (command == kResend && options.resends) {
      Resend(buffer.data(), *size);
      continue;
    }
    if (command == kWriteRegister) {
      RewriteWrites(buffer.data(), *size);
      for (std::size_t at = kHeaderBytes; at + 8 <= *size; at += 8)
        if (Word(&buffer[at]) == kStreamAddressAt && stream_client.sin_addr.s_addr == 0)
          stream_client.sin_addr = from.sin_addr;
    }
    Client& client = ClientAt(from);
    for (std::size_t at = kHeaderBytes; command == kReadRegister && at + 4 <= *size; at += 4) {
      const std::uint32_t which = Word(&buffer[at]);
      if (which == kCapabilityRegister || which == kStreamSourcePortAt)
        client.rewritten[request] = {which, at};
    }
    client.to_camera.SendTo(camera, buffer.data(), *size);
  }
}

// Changes the stream's destination to the relay, which forwards the stream to the client.
void GigeRelay::State::RewriteWrites(std::uint8_t* request, std::size_t size) {
  for (std::size_t at = kHeaderBytes; at + 8 <= size; at += 8) {
    const std::uint32_t which = Word(request + at), value = Word(request + at + 4);
    if (value == 0) continue;
    if (which == kStreamPortAt) {
      stream_client.sin_family = AF_INET;
      stream_client.sin_port = htons(static_cast<std::uint16_t>(value & 0xFFFF));
      PutWord(request + at + 4, (value & 0xFFFF0000u) | camera_stream.Port());
    }
    if (which == kStreamAddressAt) {
      stream_client.sin_addr.s_addr = htonl(value);
      PutWord(request + at + 4, ntohl(camera.sin_addr.s_addr));
    }
  }
}

void GigeRelay::State::FromCamera(Client& client) {
  sockaddr_in from{};
  while (const auto size = client.to_camera.Receive(buffer, from)) {
    if (*size < kHeaderBytes || !control_passes) continue;
    const std::uint16_t command = Half(&buffer[2]), request = Half(&buffer[6]);
    if (command == kDiscoveryAck && *size >= kHeaderBytes + kCurrentAddressAt + 4)
      PutWord(&buffer[kHeaderBytes + kCurrentAddressAt], Ipv4(options.address).value());
    if (const auto found = client.rewritten.find(request);
        command == kReadRegisterAck && found != client.rewritten.end()) {
      const auto [which, at] = found->second;
      client.rewritten.erase(found);
      if (at + 4 <= *size && which == kStreamSourcePortAt)
        PutWord(&buffer[at], public_stream.Port());
      else if (at + 4 <= *size && options.resends)
        PutWord(&buffer[at], Word(&buffer[at]) | kResendCapability);
    }
    public_control.SendTo(client.address, buffer.data(), *size);
  }
}

void GigeRelay::State::FromStream() {
  sockaddr_in from{};
  for (int i = 0; i < kPacketsInARound; ++i) {
    const auto size = camera_stream.Receive(buffer, from);
    if (!size) break;
    if (*size < kHeaderBytes) continue;
    StreamPacket packet{Bytes(buffer.begin(), buffer.begin() + static_cast<std::ptrdiff_t>(*size))};
    KeptFrame& frame = FrameOf(packet.Frame());
    {
      const MutexLock lock(mutex);
      ++statistics.packets;
    }
    const std::uint32_t number = packet.Number();
    StreamPacket& kept_packet = frame.packets[number] = std::move(packet);
    Forward(kept_packet, frame.late);
  }
}

GigeRelay::State::KeptFrame& GigeRelay::State::FrameOf(std::uint16_t number) {
  for (KeptFrame& frame : kept)
    if (frame.number == number) return frame;
  if (kept.size() == kFramesKept) kept.pop_front();
  KeptFrame& frame = kept.emplace_back();
  frame.number = number;
  frame.late = Draw(options.seed, number, 0, 0) < options.faults.late;
  const MutexLock lock(mutex);
  ++statistics.frames;
  if (frame.late) ++statistics.late_frames;
  return frame;
}

// Sends one packet over the faulty link.
void GigeRelay::State::Forward(StreamPacket& packet, bool late) {
  const GigeLinkFaults& faults = options.faults;
  const std::uint64_t attempt = packet.times_sent++;
  const auto happens = [&](double share, std::uint64_t decision) {
    return share > 0 &&
           Draw(options.seed, packet.Frame(), packet.Number(), kDecisions * attempt + decision) < share;
  };
  if (!stream_passes) return;
  const std::optional<Bytes> predecessor = std::exchange(swapped, std::nullopt);
  const bool lost = happens(faults.lost, 1), doubled = !lost && happens(faults.doubled, 2),
             swap = !lost && !predecessor && packet.Kind() != kTrailer && happens(faults.swapped, 3);
  const auto send = [&](const Bytes& bytes) {
    if (late)
      Hold(bytes, Clock::now() + faults.late_by);
    else if (!held.empty())
      Hold(bytes, Clock::now());
    else
      ToClient(bytes);
  };
  if (swap)
    swapped = packet.bytes;
  else if (!lost)
    send(packet.bytes);
  if (doubled) send(packet.bytes);
  if (predecessor) send(*predecessor);
  const MutexLock lock(mutex);
  statistics.lost += lost;
  statistics.doubled += doubled;
  statistics.swapped += swap;
}

void GigeRelay::State::Hold(const Bytes& bytes, Clock::time_point until) {
  if (!held.empty()) until = std::max(until, held.back().until);
  held.push_back({until, bytes});
}

void GigeRelay::State::SendHeld() {
  const auto now = Clock::now();
  for (; !held.empty() && held.front().until <= now; held.pop_front())
    if (stream_passes) ToClient(held.front().bytes);
}

// `request`: after the header stream channel (2), frame (2), first packet (4), last packet (4).
void GigeRelay::State::Resend(const std::uint8_t* request, std::size_t size) {
  if (size < kHeaderBytes + 12) return;
  const std::uint16_t number = Half(request + 10);
  const std::uint32_t first = Word(request + 12) & 0xFFFFFF, last = Word(request + 16) & 0xFFFFFF;
  std::uint64_t resent = 0;
  for (KeptFrame& frame : kept)
    if (frame.number == number)
      for (auto it = frame.packets.lower_bound(first); it != frame.packets.end() && it->first <= last; ++it) {
        Forward(it->second, false);
        ++resent;
      }
  const MutexLock lock(mutex);
  ++statistics.resend_requests;
  statistics.resent += resent;
}

GigeRelay::GigeRelay(const GigeRelayOptions& options) : state_(std::make_unique<State>(options)) {}
GigeRelay::~GigeRelay() = default;

void GigeRelay::PassControl(bool passes) { state_->control_passes = passes; }
void GigeRelay::PassStream(bool passes) { state_->stream_passes = passes; }
void GigeRelay::Pull() {
  PassControl(false);
  PassStream(false);
}
void GigeRelay::PutBack() {
  PassControl(true);
  PassStream(true);
}

GigeRelayStatistics GigeRelay::Statistics() const {
  const MutexLock lock(state_->mutex);
  return state_->statistics;
}

}  // namespace ulf::acquisition
