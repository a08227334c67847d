#include "acquisition/simulator/gige/gvsp_sender.h"

#include <poll.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <optional>
#include <thread>
#include <utility>

#include "acquisition/gige_vision/gvcp.h"
#include "core/base/mutex.h"

namespace ulf::acquisition {
namespace {

using PacketClock = std::chrono::steady_clock;
using gvcp::PutHalf;
using gvcp::PutWord;

// Status (2), frame number (2), kind of packet (1), packet number (3).
constexpr std::size_t kStreamHeaderBytes = 8, kAroundPayload = 20 + 8 + kStreamHeaderBytes;
constexpr std::uint32_t kLeaderKind = 1, kTrailerKind = 2, kPayloadKind = 3;
constexpr std::uint32_t kImagePayload = 1, kWithChunks = 0x4000;
constexpr std::chrono::milliseconds kMostBehind(1);  // guessed
constexpr int kSendPatienceMs = 100;                 // for room in the socket; guessed

}  // namespace

struct GvspSender::State {
  explicit State(FileDescriptor s) : socket(std::move(s)), thread([this] { Run(); }) {}
  ~State() {
    {
      const MutexLock lock(mutex);
      stopping = true;
    }
    changed.notify_all();
    thread.join();
  }

  struct Job {
    GvspFrame frame;
    GvspDestination to;
  };

  void Run();
  void SendFrame(const Job& job);
  void SendPacket(const Job& job, std::uint32_t kind, std::uint32_t number, const std::uint8_t* body,
                  std::size_t size);

  const FileDescriptor socket;
  Mutex mutex;
  ConditionVariable changed;
  std::optional<Job> job ULF_GUARDED_BY(mutex);  // until it has been sent
  bool stopping ULF_GUARDED_BY(mutex) = false;
  // Used by the thread alone.
  std::vector<std::uint8_t> packet;
  PacketClock::time_point due;
  std::thread thread;
};

void GvspSender::State::Run() {
  prctl(PR_SET_TIMERSLACK, 1);  // pauses are microseconds
  MutexLock lock(mutex);
  while (true) {
    changed.wait(lock, [this]() ULF_REQUIRES(mutex) { return stopping || job; });
    if (stopping) return;
    const Job now = std::move(*job);
    lock.unlock();
    SendFrame(now);
    lock.lock();
    job.reset();
    changed.notify_all();
  }
}

void GvspSender::State::SendPacket(const Job& sent, std::uint32_t kind, std::uint32_t number,
                                   const std::uint8_t* body, std::size_t size) {
  packet.resize(kStreamHeaderBytes + size);
  PutHalf(&packet[0], 0);
  PutHalf(&packet[2], sent.frame.id);
  PutWord(&packet[4], kind << 24 | number);
  std::copy_n(body, size, packet.begin() + kStreamHeaderBytes);
  // What a timer oversleeps is made up for; a thread that had to wait longer does not send its packets at
  // once.
  std::this_thread::sleep_until(due);
  if (PacketClock::now() - due > kMostBehind) due = PacketClock::now();
  while (sendto(socket.Number(), packet.data(), packet.size(), 0,
                reinterpret_cast<const sockaddr*>(&sent.to.client), sizeof sent.to.client) < 0 &&
         errno == EAGAIN) {
    pollfd room{socket.Number(), POLLOUT, 0};
    if (poll(&room, 1, kSendPatienceMs) < 1) break;
  }
  due += sent.to.pause;
  if (sent.to.bytes_per_s > 0)
    due += std::chrono::nanoseconds(
        std::llround(1e9 * static_cast<double>(size + kAroundPayload) / sent.to.bytes_per_s));
}

void GvspSender::State::SendFrame(const Job& sent) {
  const GvspFrame& frame = sent.frame;
  if (sent.to.packet_bytes <= kAroundPayload) return;
  due = std::max(due, PacketClock::now());
  const std::uint32_t payload_kind = kImagePayload | (frame.has_chunks ? kWithChunks : 0);
  std::uint8_t leader[36] = {};
  PutHalf(leader + 2, payload_kind);
  PutWord(leader + 4, static_cast<std::uint32_t>(frame.timestamp_ns >> 32));
  PutWord(leader + 8, static_cast<std::uint32_t>(frame.timestamp_ns));
  PutWord(leader + 12, frame.pixel_format);
  PutWord(leader + 16, frame.width);
  PutWord(leader + 20, frame.height);
  PutWord(leader + 24, frame.x);
  PutWord(leader + 28, frame.y);
  std::uint32_t number = 0;
  SendPacket(sent, kLeaderKind, number++, leader, sizeof leader);
  const std::size_t step = sent.to.packet_bytes - kAroundPayload;
  for (std::size_t at = 0; at < frame.payload.size(); at += step)
    SendPacket(sent, kPayloadKind, number++, &frame.payload[at], std::min(step, frame.payload.size() - at));
  std::uint8_t trailer[8] = {};
  PutHalf(trailer + 2, payload_kind);
  PutWord(trailer + 4, frame.height);
  SendPacket(sent, kTrailerKind, number, trailer, sizeof trailer);
}

GvspSender::GvspSender(FileDescriptor socket) : state_(std::make_unique<State>(std::move(socket))) {}
GvspSender::~GvspSender() = default;

void GvspSender::Send(GvspFrame frame, const GvspDestination& destination) {
  {
    State& state = *state_;
    MutexLock lock(state.mutex);
    state.changed.wait(lock, [&state]() ULF_REQUIRES(state.mutex) { return state.stopping || !state.job; });
    state.job = State::Job{std::move(frame), destination};
  }
  state_->changed.notify_all();
}

bool GvspSender::WaitUntilSent(std::chrono::milliseconds patience) {
  State& state = *state_;
  MutexLock lock(state.mutex);
  return state.changed.wait_for(
      lock, patience, [&state]() ULF_REQUIRES(state.mutex) { return state.stopping || !state.job; });
}

}  // namespace ulf::acquisition
