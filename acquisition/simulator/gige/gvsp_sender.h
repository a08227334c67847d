// Sends frames as a GigE Vision stream (GVSP, 16-bit frame numbers): leader, payload, trailer, with the pause
// between packets and the bytes a second that a client has set.
#pragma once

#include <netinet/in.h>

#include <chrono>
#include <cstdint>
#include <optional>
#include <thread>
#include <vector>

#include "core/base/file_descriptor.h"
#include "core/base/mutex.h"

namespace ulf::acquisition {

struct GvspFrame {
  std::uint16_t id = 0;
  std::uint64_t timestamp_ns = 0;  // of the camera's clock
  std::uint32_t pixel_format = 0;  // PFNC
  std::uint32_t width = 0, height = 0, x = 0, y = 0;
  std::vector<std::uint8_t> payload;  // the image's rows, then chunk data
  bool has_chunks = false;
};

struct GvspDestination {
  sockaddr_in client{};
  std::uint32_t packet_bytes = 0;  // with the headers of IP and UDP
  std::chrono::nanoseconds pause{0};
  double bytes_per_s = 0;  // at most; 0: without a limit
};

class GvspSender {
 public:
  // `socket`: a bound UDP socket.
  explicit GvspSender(FileDescriptor socket);
  ~GvspSender();
  GvspSender(const GvspSender&) = delete;
  GvspSender& operator=(const GvspSender&) = delete;

  // Hands a frame to the sending thread; waits first for a frame that is still being sent.
  void Send(GvspFrame frame, const GvspDestination& destination);
  // Waits until the last frame has left. Returns false if it has not left in this time.
  bool WaitUntilSent(std::chrono::milliseconds patience);

 private:
  using Clock = std::chrono::steady_clock;
  struct Job {
    GvspFrame frame;
    GvspDestination to;
  };

  void Run();
  void SendFrame(const Job& sent);
  void SendPacket(const Job& sent, std::uint32_t kind, std::uint32_t number, const std::uint8_t* body,
                  std::size_t size);

  const FileDescriptor socket_;
  Mutex mutex_;
  ConditionVariable changed_;
  std::optional<Job> job_ ULF_GUARDED_BY(mutex_);  // until it has been sent
  bool stopping_ ULF_GUARDED_BY(mutex_) = false;
  // Used by the thread alone.
  std::vector<std::uint8_t> packet_;
  Clock::time_point due_;
  std::thread thread_;
};

}  // namespace ulf::acquisition
