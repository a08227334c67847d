#include "acquisition/aravis/stream_guard.h"

#include <arpa/inet.h>
#include <linux/filter.h>
#include <linux/sock_diag.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <limits>
#include <vector>

#include "core/base/error.h"

namespace ulf::acquisition {
namespace {

constexpr std::size_t kIpAndUdpBytes = 28;
// The sockets at the port, in the order in which they were bound.
constexpr std::uint32_t kPass = 0, kDiscard = 1;

// One way of numbering frames. GVSP, all big-endian: status (2), frame number (2), kind of packet (1), packet
// number (3); with 64-bit frame numbers: status (2), flags (2), kind (1), reserved (3), frame number (8),
// packet number (4).
struct Numbering {
  std::uint32_t header_bytes, number_at, number_mask;
};
constexpr Numbering kPlain{8, 4, 0x00FFFFFF}, kExtended{20, 16, 0xFFFFFFFF};
constexpr std::uint32_t kKindAt = 4, kExtendedFlag = 0x80, kKindMask = 0x7F;
enum Kind : std::uint32_t { kLeader = 1, kTrailer = 2, kPayload = 3 };
// A leader, behind the header: flags (2), type of payload (2), time (8), pixel format (4), width (4), height
// (4), offsets (8), padding (4).
constexpr std::uint32_t kTypeAt = 2, kFormatAt = 12, kWidthAt = 16, kHeightAt = 20, kLeaderBytes = 36;
constexpr std::uint32_t kTypeMask = 0x3FFF, kImage = 1, kImageWithChunks = 5;
constexpr std::uint32_t kWidest = 0xFFFF;  // so that a product has 32 bits

// Finish() fills in the jumps to its end. The program must never read past a packet's end: the kernel would
// let such a packet through.
class Program {
 public:
  void Do(int code, std::uint32_t value) { code_.push_back({static_cast<std::uint16_t>(code), 0, 0, value}); }
  void LoadByte(std::uint32_t at) { Do(BPF_LD | BPF_B | BPF_ABS, at); }
  void LoadHalf(std::uint32_t at) { Do(BPF_LD | BPF_H | BPF_ABS, at); }
  void LoadWord(std::uint32_t at) { Do(BPF_LD | BPF_W | BPF_ABS, at); }
  void LoadLength() { Do(BPF_LD | BPF_W | BPF_LEN, 0); }
  void And(std::uint32_t mask) { Do(BPF_ALU | BPF_AND | BPF_K, mask); }
  // Send the packet to the discarding socket unless the loaded value ...
  void RequireEqual(std::uint32_t value) { Require(BPF_JEQ | BPF_K, value, true); }
  void RequireAtLeast(std::uint32_t value) { Require(BPF_JGE | BPF_K, value, true); }
  void RequireAtMost(std::uint32_t value) { Require(BPF_JGT | BPF_K, value, false); }
  void RequireAtMostX() { Require(BPF_JGT | BPF_X, 0, false); }
  void Pass() { Do(BPF_RET | BPF_K, kPass); }
  // If the loaded value has the bits (or equals the value), the program continues at Land() of the result.
  std::size_t JumpIf(int test, std::uint32_t value) {
    Do(BPF_JMP | test | BPF_K, value);
    return code_.size() - 1;
  }
  void Land(std::size_t jump) { code_[jump].jt = Distance(jump); }
  std::vector<sock_filter> Finish() {
    for (const auto& [jump, when] : to_discard_) (when ? code_[jump].jt : code_[jump].jf) = Distance(jump);
    Do(BPF_RET | BPF_K, kDiscard);
    return code_;
  }

 private:
  void Require(int test, std::uint32_t value, bool holds) {
    Do(BPF_JMP | test, value);
    to_discard_.emplace_back(code_.size() - 1, !holds);
  }
  std::uint8_t Distance(std::size_t jump) const {
    const std::size_t distance = code_.size() - jump - 1;
    if (distance > 255) throw Error("a packet filter of {} steps is too long", code_.size());
    return static_cast<std::uint8_t>(distance);
  }
  std::vector<sock_filter> code_;
  std::vector<std::pair<std::size_t, bool>> to_discard_;
};

std::uint32_t AtMost32(std::uint64_t value) {
  return static_cast<std::uint32_t>(
      std::min<std::uint64_t>(value, std::numeric_limits<std::uint32_t>::max()));
}

void CheckLeader(Program& program, const Numbering& numbering, const StreamBounds& bounds) {
  const std::uint32_t at = numbering.header_bytes;
  program.LoadWord(numbering.number_at);
  program.And(numbering.number_mask);
  program.RequireEqual(0);
  program.LoadLength();
  program.RequireAtLeast(at + kLeaderBytes);
  program.LoadHalf(at + kTypeAt);
  program.And(kTypeMask);
  const std::size_t image = program.JumpIf(BPF_JEQ, kImage);
  program.RequireEqual(kImageWithChunks);
  program.Land(image);
  // Stores in cell 0 how many pixels the payload can hold at the format's bits per pixel.
  program.LoadWord(at + kFormatAt);
  program.Do(BPF_ALU | BPF_RSH | BPF_K, 16);
  program.And(0xFF);
  program.RequireAtLeast(1);
  program.Do(BPF_MISC | BPF_TAX, 0);
  program.Do(BPF_LD | BPF_IMM, AtMost32(8 * std::uint64_t{bounds.payload_bytes}));
  program.Do(BPF_ALU | BPF_DIV | BPF_X, 0);
  program.Do(BPF_ST, 0);
  program.LoadWord(at + kHeightAt);
  program.RequireAtMost(kWidest);
  program.Do(BPF_MISC | BPF_TAX, 0);
  program.LoadWord(at + kWidthAt);
  program.RequireAtMost(kWidest);
  program.Do(BPF_ALU | BPF_MUL | BPF_X, 0);
  program.Do(BPF_LDX | BPF_MEM, 0);
  program.RequireAtMostX();
  program.Pass();
}

// Checks a packet after its numbering is known.
void CheckPacket(Program& program, const Numbering& numbering, const StreamBounds& bounds) {
  const std::size_t block = bounds.packet_bytes - kIpAndUdpBytes - numbering.header_bytes;
  const std::uint32_t blocks = AtMost32((bounds.payload_bytes + block - 1) / block);
  program.LoadLength();
  program.RequireAtLeast(numbering.header_bytes);
  program.LoadByte(kKindAt);
  program.And(kKindMask);
  const std::size_t leader = program.JumpIf(BPF_JEQ, kLeader), payload = program.JumpIf(BPF_JEQ, kPayload);
  program.RequireEqual(kTrailer);
  for (const bool is_payload : {false, true}) {
    if (is_payload) program.Land(payload);
    program.LoadWord(numbering.number_at);
    program.And(numbering.number_mask);
    program.RequireAtLeast(1);
    program.RequireAtMost(is_payload ? blocks : blocks + 1);
    program.Pass();
  }
  program.Land(leader);
  CheckLeader(program, numbering, bounds);
}

std::vector<sock_filter> ProgramFor(const StreamBounds& bounds, std::uint32_t camera) {
  Program program;
  program.LoadLength();
  program.RequireAtLeast(kPlain.header_bytes);
  program.RequireAtMost(AtMost32(bounds.packet_bytes - kIpAndUdpBytes));
  // The IP header: IPv4 without options, so that the following offsets are fixed.
  const auto ip = [](int at) { return static_cast<std::uint32_t>(SKF_NET_OFF + at); };
  program.LoadByte(ip(0));
  program.RequireEqual(0x45);
  program.LoadWord(ip(12));
  program.RequireEqual(camera);
  if (bounds.source_port != 0) {
    program.LoadHalf(ip(20));
    program.RequireEqual(static_cast<std::uint32_t>(bounds.source_port));
  }
  program.LoadByte(kKindAt);
  const std::size_t extended = program.JumpIf(BPF_JSET, kExtendedFlag);
  CheckPacket(program, kPlain, bounds);
  program.Land(extended);
  CheckPacket(program, kExtended, bounds);
  return program.Finish();
}

void SetOption(int socket, int option, const void* value, socklen_t size) {
  if (setsockopt(socket, SOL_SOCKET, option, value, size) != 0)
    throw Error("the packets of a stream cannot be checked: {}", std::strerror(errno));
}

}  // namespace

StreamGuard::StreamGuard(int socket, const StreamBounds& bounds) : bounds_(bounds) {
  if (bounds.packet_bytes <= kIpAndUdpBytes + kExtended.header_bytes || bounds.payload_bytes == 0)
    throw Error("packets of {} bytes cannot carry frames of {}", bounds.packet_bytes, bounds.payload_bytes);
  sockaddr_in at{};
  socklen_t size = sizeof at;
  if (getsockname(socket, reinterpret_cast<sockaddr*>(&at), &size) != 0)
    throw Error("the packets of a stream cannot be checked: {}", std::strerror(errno));
  discard_socket_ = FileDescriptor(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  const int yes = 1;
  sock_filter nothing{BPF_RET | BPF_K, 0, 0, 0};
  const sock_fprog discard_all{1, &nothing};
  SetOption(discard_socket_.Number(), SO_ATTACH_FILTER, &discard_all, sizeof discard_all);
  SetOption(discard_socket_.Number(), SO_REUSEPORT, &yes, sizeof yes);
  SetOption(socket, SO_REUSEPORT, &yes, sizeof yes);
  if (bind(discard_socket_.Number(), reinterpret_cast<const sockaddr*>(&at), sizeof at) != 0)
    throw Error("the packets of a stream cannot be checked: {}", std::strerror(errno));
  Attach();
}

void StreamGuard::Attach() {
  in_addr camera{};
  if (inet_pton(AF_INET, bounds_.camera.c_str(), &camera) != 1)
    throw Error("'{}' is not an IPv4 address", bounds_.camera);
  std::vector<sock_filter> code = ProgramFor(bounds_, ntohl(camera.s_addr));
  const sock_fprog program{static_cast<unsigned short>(code.size()), code.data()};
  SetOption(discard_socket_.Number(), SO_ATTACH_REUSEPORT_CBPF, &program, sizeof program);
}

void StreamGuard::AllowAnyPort() {
  bounds_.source_port = 0;
  Attach();
}

std::uint64_t StreamGuard::Refused() const {
  std::array<std::uint32_t, SK_MEMINFO_VARS> counts{};
  socklen_t size = sizeof counts;
  if (getsockopt(discard_socket_.Number(), SOL_SOCKET, SO_MEMINFO, counts.data(), &size) != 0) return 0;
  return counts[SK_MEMINFO_DROPS];
}

}  // namespace ulf::acquisition
