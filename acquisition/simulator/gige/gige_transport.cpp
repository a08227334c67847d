#include "acquisition/simulator/gige/gige_transport.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <ctime>
#include <iterator>
#include <utility>

#include "acquisition/gige_vision/gige_vision_probe.h"
#include "acquisition/gige_vision/gvcp.h"
#include "acquisition/simulator/gige/gige_registers.h"

namespace ulf::acquisition {
namespace {

// PtpStatus, as IEEE 1588 numbers the states of a port.
constexpr std::uint32_t kPtpDisabled = 3, kPtpListening = 4, kPtpUncalibrated = 8, kPtpSlave = 9;
// How far a clock that is set stays from its master, and for which share of the time until then it only
// listens. Made up.
constexpr std::int64_t kPtpResidualNs = 180;
constexpr double kPtpListens = 0.5;
// A clock that lost its master drifts as an ordinary quartz does.
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

GigeTransport::GigeTransport(FileDescriptor stream_socket, RegisterMemory& memory,
                             const SimulatedClock& clock)
    : memory_(memory), clock_(clock), sender_(std::move(stream_socket)), has_master_(clock.ptp_lock_s >= 0) {}

bool GigeTransport::IsSet() const {
  return FollowsMaster() && SecondsFrom(follows_since_ns_) >= clock_.ptp_lock_s;
}

std::int64_t GigeTransport::AheadNs() const {
  if (IsSet()) return kPtpResidualNs;
  if (drifts_since_ns_ == 0) return std::llround(1e9 * clock_.ahead_s);
  return kPtpResidualNs + std::llround(1e9 * kDriftShare * SecondsFrom(drifts_since_ns_));
}

std::uint32_t GigeTransport::PtpStatus() const {
  if (!ptp_on_) return kPtpDisabled;
  if (!has_master_ || SecondsFrom(follows_since_ns_) < kPtpListens * clock_.ptp_lock_s) return kPtpListening;
  return IsSet() ? kPtpSlave : kPtpUncalibrated;
}

void GigeTransport::Switch(bool on, bool master) {
  const bool followed = FollowsMaster(), was_set = IsSet();
  ptp_on_ = on;
  has_master_ = master;
  if (!followed && FollowsMaster()) follows_since_ns_ = HostNs();
  if (was_set && !IsSet()) drifts_since_ns_ = HostNs();
}

void GigeTransport::BeforeRequest(const GvcpAccess& access) {
  const MutexLock lock(mutex_);
  if (access.written && access.address == kPtpEnableAt) Switch(*access.written != 0, has_master_);
  // They change without a request.
  if (access.address == kPtpStatusAt) memory_.Write(kPtpStatusAt, PtpStatus());
  if (access.written && access.address == kPtpLatchAt)
    memory_.Write(kPtpOffsetAt, static_cast<std::uint32_t>(static_cast<std::int32_t>(
                                    std::clamp<std::int64_t>(AheadNs(), INT32_MIN, INT32_MAX))));
}

void GigeTransport::HearMaster(bool heard) {
  const MutexLock lock(mutex_);
  Switch(ptp_on_, heard);
}

std::uint64_t GigeTransport::ClockNs(std::uint64_t host_ns) const {
  const MutexLock lock(mutex_);
  return host_ns + static_cast<std::uint64_t>(AheadNs());
}

void GigeTransport::Send(GvspFrame frame, const ChunkValues& values) {
  const auto read = [this](std::uint32_t address) { return memory_.Read(address); };
  GvspDestination to{.client = SocketAddress(read(kStreamAddressAt), static_cast<int>(read(kStreamPortAt)))};
  to.packet_bytes = read(kPacketSizeAt) & kPacketSizeMask;
  to.pause = std::chrono::nanoseconds(read(kPacketDelayAt));
  if (read(kThroughputModeAt) != 0) to.bytes_per_s = read(kThroughputLimitAt);
  if (read(kChunkModeAt) != 0 && !clock_.forgets_chunks) {
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
  sender_.Send(std::move(frame), to);
}

}  // namespace ulf::acquisition
