#include "acquisition/simulator/gige/gige_transport.h"

#include <arpa/inet.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <ctime>
#include <iterator>
#include <utility>

#include "acquisition/gige_vision/gvcp.h"
#include "acquisition/simulator/gige/gige_registers.h"
#include "core/base/mutex.h"

namespace ulf::acquisition {
namespace {

// PtpStatus, as IEEE 1588 numbers the states of a port.
constexpr std::uint32_t kPtpDisabled = 3, kPtpListening = 4, kPtpUncalibrated = 8, kPtpSlave = 9;
// How far a clock that is set stays from its master, and for which share of the time until then it only
// listens. Made up.
constexpr std::int64_t kPtpResidualNs = 180;
constexpr double kPtpListens = 0.5;
// Of a clock that lost its master: that of an ordinary quartz.
constexpr double kDriftShare = 20e-6;

std::uint64_t HostNs() {
  timespec now{};
  clock_gettime(CLOCK_REALTIME, &now);
  return static_cast<std::uint64_t>(now.tv_sec) * 1'000'000'000u + static_cast<std::uint64_t>(now.tv_nsec);
}
double SecondsFrom(std::uint64_t host_ns) { return 1e-9 * static_cast<double>(HostNs() - host_ns); }

void AppendWord(std::vector<std::uint8_t>& bytes, std::uint32_t value) {
  bytes.resize(bytes.size() + 4);
  gvcp::PutWord(&bytes[bytes.size() - 4], value);
}
// A chunk's eight bytes, its number and its length, big-endian.
void AppendChunk(std::vector<std::uint8_t>& bytes, std::uint32_t id, std::uint64_t value) {
  AppendWord(bytes, static_cast<std::uint32_t>(value >> 32));
  AppendWord(bytes, static_cast<std::uint32_t>(value));
  AppendWord(bytes, id);
  AppendWord(bytes, kChunkValueBytes);
}

}  // namespace

struct GigeTransport::State {
  State(FileDescriptor stream_socket, RegisterMemory& m, const SimulatedClock& c)
      : memory(m), clock(c), sender(std::move(stream_socket)), has_master(clock.ptp_lock_s >= 0) {}

  bool FollowsMaster() const ULF_REQUIRES(mutex) { return ptp_on && has_master; }
  bool IsSet() const ULF_REQUIRES(mutex) {
    return FollowsMaster() && SecondsFrom(follows_since_ns) >= clock.ptp_lock_s;
  }
  std::int64_t AheadNs() const ULF_REQUIRES(mutex) {
    if (IsSet()) return kPtpResidualNs;
    if (drifts_since_ns == 0) return std::llround(1e9 * clock.ahead_s);
    return kPtpResidualNs + std::llround(1e9 * kDriftShare * SecondsFrom(drifts_since_ns));
  }
  std::uint32_t PtpStatus() const ULF_REQUIRES(mutex) {
    if (!ptp_on) return kPtpDisabled;
    if (!has_master || SecondsFrom(follows_since_ns) < kPtpListens * clock.ptp_lock_s) return kPtpListening;
    return IsSet() ? kPtpSlave : kPtpUncalibrated;
  }
  // What decides whether the camera follows a master.
  void Switch(bool on, bool master) ULF_REQUIRES(mutex);

  RegisterMemory& memory;
  const SimulatedClock clock;
  GvspSender sender;
  mutable Mutex mutex;
  bool ptp_on ULF_GUARDED_BY(mutex) = false, has_master ULF_GUARDED_BY(mutex);
  std::uint64_t follows_since_ns ULF_GUARDED_BY(mutex) = 0;  // of a camera that follows a master
  std::uint64_t drifts_since_ns ULF_GUARDED_BY(mutex) = 0;   // of a clock that was set; 0: it was not
};

void GigeTransport::State::Switch(bool on, bool master) {
  const bool followed = FollowsMaster(), was_set = IsSet();
  ptp_on = on;
  has_master = master;
  if (!followed && FollowsMaster()) follows_since_ns = HostNs();
  if (was_set && !IsSet()) drifts_since_ns = HostNs();
}

GigeTransport::GigeTransport(FileDescriptor stream_socket, RegisterMemory& memory,
                             const SimulatedClock& clock)
    : state_(std::make_unique<State>(std::move(stream_socket), memory, clock)) {}
GigeTransport::~GigeTransport() = default;

void GigeTransport::BeforeRequest(const GvcpAccess& access) {
  const MutexLock lock(state_->mutex);
  if (access.written && access.address == kPtpEnableAt)
    state_->Switch(*access.written != 0, state_->has_master);
  // They change without a request.
  if (access.address == kPtpStatusAt) state_->memory.Write(kPtpStatusAt, state_->PtpStatus());
  if (access.written && access.address == kPtpLatchAt)
    state_->memory.Write(kPtpOffsetAt,
                         static_cast<std::uint32_t>(static_cast<std::int32_t>(
                             std::clamp<std::int64_t>(state_->AheadNs(), INT32_MIN, INT32_MAX))));
}

void GigeTransport::HearMaster(bool heard) {
  const MutexLock lock(state_->mutex);
  state_->Switch(state_->ptp_on, heard);
}

std::uint64_t GigeTransport::ClockNs(std::uint64_t host_ns) const {
  const MutexLock lock(state_->mutex);
  return host_ns + static_cast<std::uint64_t>(state_->AheadNs());
}

void GigeTransport::WaitUntilSent(std::chrono::milliseconds patience) {
  state_->sender.WaitUntilSent(patience);
}

void GigeTransport::Send(GvspFrame frame, const ChunkValues& values) {
  const auto read = [this](std::uint32_t address) { return state_->memory.Read(address); };
  GvspDestination to;
  to.client.sin_family = AF_INET;
  to.client.sin_addr.s_addr = htonl(read(kStreamAddressAt));
  to.client.sin_port = htons(static_cast<std::uint16_t>(read(kStreamPortAt)));
  to.packet_bytes = read(kPacketSizeAt) & kPacketSizeMask;
  to.pause = std::chrono::nanoseconds(read(kPacketDelayAt));
  if (read(kThroughputModeAt) != 0) to.bytes_per_s = read(kThroughputLimitAt);
  if (read(kChunkModeAt) != 0 && !state_->clock.forgets_chunks) {
    frame.has_chunks = true;
    const auto image_bytes = static_cast<std::uint32_t>(frame.payload.size());
    AppendWord(frame.payload, kImageChunkId);
    AppendWord(frame.payload, image_bytes);
    const std::uint64_t told[] = {std::bit_cast<std::uint64_t>(values.exposure_us),
                                  std::bit_cast<std::uint64_t>(values.gain_db), frame.timestamp_ns,
                                  values.frame_id, values.lines};
    static_assert(std::size(told) == kChunks.size());
    for (std::uint32_t i = 0; i < kChunks.size(); ++i)
      if (read(kChunkEnableAt + 4 * i) != 0) AppendChunk(frame.payload, kChunks[i].id, told[i]);
  }
  state_->sender.Send(std::move(frame), to);
}

}  // namespace ulf::acquisition
