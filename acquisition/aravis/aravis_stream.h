// The receiving side of a session: the library's stream with its buffers, receive socket, resending and
// thread priority as the options say, and its counters named for people. On GigE Vision a guard stands before
// its socket (stream_guard.h) before the first buffer is given to it.
#pragma once

#include <atomic>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "acquisition/aravis/aravis_configuration.h"
#include "acquisition/aravis/aravis_options.h"
#include "acquisition/aravis/aravis_session.h"
#include "acquisition/aravis/stream_guard.h"

namespace ulf::acquisition {

class AravisStream {
 public:
  // Gives the session its stream, with buffers, not yet acquiring. Throws Error.
  AravisStream(AravisSession& session, const std::string& who, const AravisOptions& options,
               const AravisConfigured& configured);

  // False: the system refused the priority that was asked for; none: not yet known, or none asked for.
  std::optional<bool> PriorityGranted() const;
  // Where the system gave a smaller receive buffer than was asked for, with the way out; none: it did not.
  // Known when the first packets are there.
  std::optional<std::string> SocketBufferWarning() const;
  // Why packets reach the library unchecked; none: they are checked.
  const std::optional<std::string>& UnguardedReason() const { return unguarded_reason_; }
  std::uint64_t RefusedPackets() const { return guard_ ? guard_->Refused() : 0; }
  // Of a camera that told the wrong port: true where it was checked until now.
  bool AllowAnyPort();
  // To be called by the thread that pops buffers, or with that thread at rest.
  std::vector<std::pair<std::string, double>> Transport() const;

 private:
  // Outlives this object: the library's thread ends when the session does.
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
  // What the kernel really gave the stream's socket; none where it cannot be found.
  std::optional<std::size_t> GrantedSocketBuffer() const;

  int socket_ = -1;                     // the library's; -1: another bus, or not found
  std::shared_ptr<StreamGuard> guard_;  // none: see unguarded_reason_
  std::optional<std::string> unguarded_reason_;
  std::size_t buffers_ = 0;
  std::size_t socket_buffer_bytes_ = 0;  // asked for
};

}  // namespace ulf::acquisition
