// Sets up the receiving side of a session: the library's stream with its buffers, receive socket, resending
// and thread priority according to the options. It reads the stream's counters, and on GigE Vision gives its
// socket a packet filter (stream_guard.h) before the first buffer is queued. The session owns the stream.
#pragma once

#include <atomic>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/aravis/aravis_configuration.h"
#include "acquisition/aravis/aravis_options.h"
#include "acquisition/aravis/aravis_session.h"
#include "acquisition/aravis/stream_guard.h"
#include "acquisition/device/transport_figures.h"

namespace ulf::acquisition {

class AravisStream {
 public:
  // Creates the session's stream with its buffers; acquisition has not started. Throws Error.
  AravisStream(AravisSession& session, const std::string& who, const AravisOptions& options,
               const AravisConfigured& configured);

  // Returns a warning if the system granted a receive buffer smaller than a frame, or than the URI asks for;
  // none if it is large enough or unknown.
  std::optional<std::string> SocketBufferWarning() const;
  // Returns messages about what the system did not grant and which packets were refused, each once.
  // `frames_came`: at least one frame has arrived.
  std::vector<std::string> TakeNotes(bool frames_came);
  std::uint64_t RefusedPackets() const { return guard_ ? guard_->Refused() : 0; }
  // Stops checking the source port, for a camera that reports a wrong one. Returns whether it was checked.
  bool AllowAnyPort();
  // Returns counters and settings for display. Only the thread that takes the stream's buffers may call it,
  // or any thread while that one is stopped.
  TransportFigures Transport() const;

 private:
  // The state of the library's thread, which outlives this object and ends with the session.
  struct Thread {
    ThreadPriority wanted = ThreadPriority::kNormal;
    std::atomic<int> granted{-1};
  };
  static void OnStream(void* thread, ArvStreamCallbackType type, ArvBuffer* buffer);

  AravisSession& session_;
  AravisOptions options_;
  AravisConfigured configured_;
  std::shared_ptr<Thread> thread_;
  void Guard();
  // Returns whether the system granted the priority; none if not yet known, or no priority was asked for.
  std::optional<bool> PriorityGranted() const;
  // Returns the receive buffer that the kernel granted, in bytes; none where the socket was not found.
  std::optional<std::size_t> GrantedSocketBuffer() const;

  int socket_ = -1;                              // the library's; -1: another bus, or not found
  std::shared_ptr<StreamGuard> guard_;           // none: see unguarded_reason_
  std::optional<std::string> unguarded_reason_;  // why there is no packet filter
  bool said_priority_ = false, said_socket_buffer_ = false, said_refused_ = false;
  std::size_t buffers_ = 0;
  std::size_t socket_buffer_bytes_ = 0;  // asked for
};

}  // namespace ulf::acquisition
