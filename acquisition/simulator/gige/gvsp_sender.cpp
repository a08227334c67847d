#include "acquisition/simulator/gige/gvsp_sender.h"

#include <poll.h>
#include <sys/prctl.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <thread>
#include <utility>

#include "acquisition/gige_vision/gvcp.h"

namespace ulf::acquisition {
namespace {

using gvcp::PutHalf;
using gvcp::PutWord;

// Status (2), frame number (2), kind of packet (1), packet number (3).
constexpr std::size_t kStreamHeaderBytes = 8, kAroundPayload = 20 + 8 + kStreamHeaderBytes;
constexpr std::uint32_t kLeaderKind = 1, kTrailerKind = 2, kPayloadKind = 3;
constexpr std::uint32_t kImagePayload = 1, kWithChunks = 0x4000;
constexpr std::chrono::milliseconds kMostBehind(1);  // guessed
constexpr int kSendPatienceMs = 100;                 // for room in the socket; guessed

}  // namespace

GvspSender::GvspSender(FileDescriptor socket) : socket_(std::move(socket)), thread_([this] { Run(); }) {}

GvspSender::~GvspSender() {
  {
    const MutexLock lock(mutex_);
    stopping_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

void GvspSender::Run() {
  prctl(PR_SET_TIMERSLACK, 1);  // pauses are microseconds
  MutexLock lock(mutex_);
  while (true) {
    changed_.wait(lock, [this]() ULF_REQUIRES(mutex_) { return stopping_ || job_; });
    if (stopping_) return;
    const Job now = std::move(*job_);
    lock.unlock();
    SendFrame(now);
    lock.lock();
    job_.reset();
    changed_.notify_all();
  }
}

void GvspSender::SendPacket(const Job& sent, std::uint32_t kind, std::uint32_t number,
                            const std::uint8_t* body, std::size_t size) {
  packet_.resize(kStreamHeaderBytes + size);
  PutHalf(&packet_[0], 0);
  PutHalf(&packet_[2], sent.frame.id);
  PutWord(&packet_[4], kind << 24 | number);
  std::copy_n(body, size, packet_.begin() + kStreamHeaderBytes);
  // What a timer oversleeps is made up for; a thread that had to wait longer does not send its packets at
  // once.
  std::this_thread::sleep_until(due_);
  if (Clock::now() - due_ > kMostBehind) due_ = Clock::now();
  while (sendto(socket_.Number(), packet_.data(), packet_.size(), 0,
                reinterpret_cast<const sockaddr*>(&sent.to.client), sizeof sent.to.client) < 0 &&
         errno == EAGAIN) {
    pollfd room{socket_.Number(), POLLOUT, 0};
    if (poll(&room, 1, kSendPatienceMs) < 1) break;
  }
  due_ += sent.to.pause;
  if (sent.to.bytes_per_s > 0)
    due_ += std::chrono::nanoseconds(
        std::llround(1e9 * static_cast<double>(size + kAroundPayload) / sent.to.bytes_per_s));
}

void GvspSender::SendFrame(const Job& sent) {
  const GvspFrame& frame = sent.frame;
  if (sent.to.packet_bytes <= kAroundPayload) return;
  due_ = std::max(due_, Clock::now());
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

void GvspSender::Send(GvspFrame frame, const GvspDestination& destination) {
  {
    MutexLock lock(mutex_);
    changed_.wait(lock, [this]() ULF_REQUIRES(mutex_) { return stopping_ || !job_; });
    job_ = Job{std::move(frame), destination};
  }
  changed_.notify_all();
}

bool GvspSender::WaitUntilSent(std::chrono::milliseconds patience) {
  MutexLock lock(mutex_);
  return changed_.wait_for(lock, patience, [this]() ULF_REQUIRES(mutex_) { return stopping_ || !job_; });
}

}  // namespace ulf::acquisition
