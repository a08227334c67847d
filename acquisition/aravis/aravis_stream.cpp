#include "acquisition/aravis/aravis_stream.h"

#include <netinet/in.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>

#include "core/base/stop_signal.h"

namespace ulf::acquisition {
namespace {

// From 1 to 99: above ordinary programs, below the kernel's threads. Guessed, as is the niceness (-20 to 19).
constexpr int kRealtimePriority = 10;
constexpr int kHighPriorityNice = -10;
// Bounds of the receive buffer, which holds two frames. Measured: with less, small frames lose packets even
// on loopback. The upper bound is guessed.
constexpr std::size_t kLeastSocketBuffer = 2 << 20, kMostSocketBuffer = 256 << 20;
// Frames that the library may fill at once: as many as fit in this memory, within bounds. Guessed.
constexpr std::size_t kPoolBytes = 64 << 20, kLeastBuffers = 4, kMostBuffers = 24;

struct Counter {
  const char* info;  // the library's name
  TransportFigure figure;
};
// In display order.
constexpr std::array kCounters{
    Counter{"n_completed_buffers", TransportFigure::kFramesCompleted},
    Counter{"n_failures", TransportFigure::kFramesFailed},
    Counter{"n_timeouts", TransportFigure::kFramesTimedOut},
    Counter{"n_aborted", TransportFigure::kFramesAborted},
    Counter{"n_missing_frames", TransportFigure::kFramesMissing},
    Counter{"n_size_mismatch_errors", TransportFigure::kSizeMismatches},
    Counter{"n_underruns", TransportFigure::kUnderruns},
    Counter{"n_received_packets", TransportFigure::kPacketsReceived},
    Counter{"n_missing_packets", TransportFigure::kPacketsMissing},
    Counter{"n_resend_requests", TransportFigure::kResendRequests},
    Counter{"n_resent_packets", TransportFigure::kPacketsResent},
    Counter{"n_resend_ratio_reached", TransportFigure::kResendLimitReached},
    Counter{"n_resend_disabled", TransportFigure::kResendsGivenUp},
    Counter{"n_duplicated_packets", TransportFigure::kPacketsTwice},
    Counter{"n_error_packets", TransportFigure::kPacketsWithErrors},
    Counter{"n_ignored_packets", TransportFigure::kPacketsIgnored},
    Counter{"n_transferred_bytes", TransportFigure::kBytesReceived},
    Counter{"n_ignored_bytes", TransportFigure::kBytesIgnored},
};

// The library does not expose its socket, so it is found among the descriptors of this process. -1: none.
int SocketAtUdpPort(int port) {
  std::error_code error;
  for (std::filesystem::directory_iterator entry("/proc/self/fd", error), end; !error && entry != end;
       entry.increment(error)) {
    const int fd = std::atoi(entry->path().filename().c_str());
    sockaddr_in at{};
    socklen_t size = sizeof at;
    int type = 0;
    socklen_t type_size = sizeof type;
    if (getsockname(fd, reinterpret_cast<sockaddr*>(&at), &size) == 0 && at.sin_family == AF_INET &&
        ntohs(at.sin_port) == port && getsockopt(fd, SOL_SOCKET, SO_TYPE, &type, &type_size) == 0 &&
        type == SOCK_DGRAM)
      return fd;
  }
  return -1;
}

// The library reads these registers without looking whether it got them, and divides by what it read: a
// camera that is gone by then would end the program.
void CheckUsbStream(ArvDevice* device, const std::string& who) {
  constexpr guint64 kSbrmAddress = 0x1d8, kSirmAddressInSbrm = 0x20;
  constexpr unsigned kMostAlignmentBits = 20;  // the library's transfers have 2^20 bytes
  const auto read = [&](guint64 address, auto value) {
    CallOrThrow(who, "the camera no longer answers; check power and cable", arv_device_read_memory, device,
                address, sizeof value, &value);
    return value;
  };
  const guint64 sirm = read(read(kSbrmAddress, guint64{0}) + kSirmAddressInSbrm, guint64{0});
  const unsigned alignment_bits = read(sirm, guint32{0}) >> 24;
  if (alignment_bits > kMostAlignmentBits)
    throw Error(
        "{}: the camera asks for transfers in steps of 2^{} bytes, which cannot be; pull its cable out and "
        "plug it in again",
        who, alignment_bits);
}

}  // namespace

AravisStream::AravisStream(AravisSession& session, const std::string& who, const AravisOptions& options,
                           const AravisConfigured& configured)
    : session_(session), options_(options), configured_(configured), thread_(std::make_shared<Thread>()) {
  thread_->wanted = options.priority;
  if (session.IsUsb()) CheckUsbStream(session.Device(), who);
  session.TakeStream(CallOrThrow(who, "stream (does another program control this camera?)",
                                 arv_camera_create_stream_full, session.Camera(), &AravisStream::OnStream,
                                 new std::shared_ptr<Thread>(thread_),
                                 [](void* thread) { delete static_cast<std::shared_ptr<Thread>*>(thread); }));
  ArvStream* stream = session.Stream();
  if (ARV_IS_GV_STREAM(stream)) {
    // The library's automatic size is one frame, which is too little for small frames.
    socket_buffer_bytes_ =
        options.socket_buffer_bytes
            ? static_cast<std::size_t>(*options.socket_buffer_bytes)
            : std::clamp(2 * configured.payload_bytes, kLeastSocketBuffer, kMostSocketBuffer);
    g_object_set(stream, "socket-buffer", ARV_GV_STREAM_SOCKET_BUFFER_FIXED, "socket-buffer-size",
                 static_cast<gint>(socket_buffer_bytes_), nullptr);
    // Sets the size now: the library would set it with the first frame, which may have lost packets by then.
    const int bytes = static_cast<int>(socket_buffer_bytes_);
    socket_ = SocketAtUdpPort(arv_gv_stream_get_port(ARV_GV_STREAM(stream)));
    if (socket_ >= 0) setsockopt(socket_, SOL_SOCKET, SO_RCVBUF, &bytes, sizeof bytes);
    // Only switches resending off: the library has switched it on where the camera supports it.
    if (!options.resend) g_object_set(stream, "packet-resend", ARV_GV_STREAM_PACKET_RESEND_NEVER, nullptr);
    if (options.packet_timeout_ms)
      g_object_set(stream, "packet-timeout", static_cast<guint>(1000 * *options.packet_timeout_ms), nullptr);
    if (options.frame_retention_ms)
      g_object_set(stream, "frame-retention", static_cast<guint>(1000 * *options.frame_retention_ms),
                   nullptr);
    Guard();
  }
  buffers_ = options.buffers ? static_cast<std::size_t>(*options.buffers)
                             : std::clamp(kPoolBytes / std::max<std::size_t>(configured.payload_bytes, 1),
                                          kLeastBuffers, kMostBuffers);
  for (std::size_t i = 0; i < buffers_; ++i)
    arv_stream_push_buffer(stream, arv_buffer_new_allocate(configured.payload_bytes));
}

// Pauses the library's thread, which must not read packets that arrived before the filter.
void AravisStream::Guard() {
  ArvStream* stream = session_.Stream();
  try {
    if (socket_ < 0) throw Error("the stream's socket was not found");
    const auto packet_bytes =
        static_cast<std::size_t>(TryCall(arv_camera_gv_get_packet_size, session_.Camera()).value_or(0));
    const auto port =
        TryCall(arv_device_get_integer_feature_value, session_.Device(), "ArvGevSCSP").value_or(0);
    arv_stream_stop_thread(stream, FALSE);
    try {
      guard_ =
          std::make_shared<StreamGuard>(socket_, StreamBounds{.camera = session_.GigeAddress(),
                                                              .source_port = static_cast<int>(port & 0xFFFF),
                                                              .payload_bytes = configured_.payload_bytes,
                                                              .packet_bytes = packet_bytes});
      session_.KeepBeyondStream(guard_);
      char byte = 0;
      while (recv(socket_, &byte, 1, MSG_DONTWAIT) >= 0) continue;
    } catch (...) {
      arv_stream_start_thread(stream);
      throw;
    }
    arv_stream_start_thread(stream);
  } catch (const Error& error) {
    unguarded_reason_ = error.what();
  }
}

bool AravisStream::AllowAnyPort() {
  if (!guard_ || !guard_->ChecksPort()) return false;
  guard_->AllowAnyPort();
  return true;
}

void AravisStream::OnStream(void* data, ArvStreamCallbackType type, ArvBuffer* /*buffer*/) {
  if (type != ARV_STREAM_CALLBACK_TYPE_INIT) return;
  InstallSignalStack();
  Thread& thread = **static_cast<std::shared_ptr<Thread>*>(data);
  if (thread.wanted == ThreadPriority::kRealtime)
    thread.granted = arv_make_thread_realtime(kRealtimePriority);
  if (thread.wanted == ThreadPriority::kHigh)
    thread.granted = arv_make_thread_high_priority(kHighPriorityNice);
}

std::optional<bool> AravisStream::PriorityGranted() const {
  const int granted = thread_->granted;
  if (granted < 0) return std::nullopt;
  return granted != 0;
}

std::optional<std::size_t> AravisStream::GrantedSocketBuffer() const {
  int bytes = 0;
  socklen_t size = sizeof bytes;
  if (socket_ < 0 || getsockopt(socket_, SOL_SOCKET, SO_RCVBUF, &bytes, &size) != 0) return std::nullopt;
  return static_cast<std::size_t>(bytes / 2);  // the kernel reports twice the size, for its own bookkeeping
}

std::vector<std::string> AravisStream::TakeNotes(bool frames_came) {
  std::vector<std::string> notes;
  if (PriorityGranted() == false && !std::exchange(said_priority_, true))
    notes.emplace_back(
        "the system refused the thread priority of the URI; allow it with 'setcap cap_sys_nice+ep' on the "
        "program, or an rtprio line in /etc/security/limits.conf");
  if (RefusedPackets() > 0 && !std::exchange(said_refused_, true))
    notes.emplace_back(
        "packets came that are not the camera's, or of a kind that it was not set to send: ulf refuses them "
        "and counts them as 'packets refused'");
  if (!frames_came || std::exchange(said_socket_buffer_, true)) return notes;
  if (unguarded_reason_)
    notes.push_back("the camera's stream is not protected from packets of other senders: " +
                    *unguarded_reason_);
  if (const auto words = SocketBufferWarning()) notes.push_back(*words);
  return notes;
}

std::optional<std::string> AravisStream::SocketBufferWarning() const {
  const auto granted = GrantedSocketBuffer();
  // A buffer smaller than a frame loses packets. A larger one is needed only where the URI asks for it.
  const std::size_t needed = options_.socket_buffer_bytes
                                 ? std::max(socket_buffer_bytes_, configured_.payload_bytes)
                                 : std::min(socket_buffer_bytes_, configured_.payload_bytes);
  if (!granted || *granted >= needed) return std::nullopt;
  return fmt::format(
      "the receive buffer has {} bytes instead of {}, and a frame has {}: packets of large frames may be "
      "lost; give socket_buffer={}, and run 'sysctl net.core.rmem_max={}' as root where the system gives "
      "less",
      *granted, socket_buffer_bytes_, configured_.payload_bytes, needed, needed);
}

TransportFigures AravisStream::Transport() const {
  TransportFigures shown;
  ArvStream* stream = session_.Stream();
  if (!stream) return shown;
  std::vector<std::string> known;
  for (guint i = 0; i < arv_stream_get_n_infos(stream); ++i)
    known.push_back(Text(arv_stream_get_info_name(stream, i)));
  for (const Counter& counter : kCounters)
    if (std::find(known.begin(), known.end(), counter.info) != known.end())
      shown.emplace_back(counter.figure,
                         static_cast<double>(arv_stream_get_info_uint64_by_name(stream, counter.info)));
  shown.emplace_back(TransportFigure::kBuffers, static_cast<double>(buffers_));
  shown.emplace_back(TransportFigure::kPayloadBytes, static_cast<double>(configured_.payload_bytes));
  if (configured_.set_fps && !options_.Triggered())
    shown.emplace_back(TransportFigure::kSetFps, *configured_.set_fps);
  if (configured_.link.throughput_limit)
    shown.emplace_back(TransportFigure::kThroughputLimit, *configured_.link.throughput_limit);
  if (const auto granted = PriorityGranted())
    shown.emplace_back(options_.priority == ThreadPriority::kRealtime ? TransportFigure::kRealTimePriority
                                                                      : TransportFigure::kHighPriority,
                       *granted);
  if (!ARV_IS_GV_STREAM(stream)) return shown;
  guint packet_timeout_us = 0, frame_retention_us = 0;
  ArvGvStreamPacketResend resend = ARV_GV_STREAM_PACKET_RESEND_NEVER;
  g_object_get(stream, "packet-timeout", &packet_timeout_us, "frame-retention", &frame_retention_us,
               "packet-resend", &resend, nullptr);
  shown.emplace_back(TransportFigure::kPacketsRefused, static_cast<double>(RefusedPackets()));
  shown.emplace_back(TransportFigure::kPacketSize, configured_.link.packet_size);
  shown.emplace_back(TransportFigure::kPacketSizeNegotiated, configured_.link.packet_size_negotiated);
  shown.emplace_back(TransportFigure::kPacketDelayNs, static_cast<double>(configured_.link.packet_delay_ns));
  shown.emplace_back(TransportFigure::kResends, resend == ARV_GV_STREAM_PACKET_RESEND_ALWAYS);
  shown.emplace_back(TransportFigure::kPacketTimeoutMs, 1e-3 * packet_timeout_us);
  shown.emplace_back(TransportFigure::kFrameRetentionMs, 1e-3 * frame_retention_us);
  shown.emplace_back(TransportFigure::kSocketBufferAsked, static_cast<double>(socket_buffer_bytes_));
  if (const auto granted = GrantedSocketBuffer())
    shown.emplace_back(TransportFigure::kSocketBuffer, static_cast<double>(*granted));
  return shown;
}

}  // namespace ulf::acquisition
