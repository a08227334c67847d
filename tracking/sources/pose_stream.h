// Poses that another program sends over a socket of this computer: a robot's controller, a motion-capture
// bridge. Lines of text, described for their authors in docs/tracking.md:
//
//   time tx ty tz qx qy qz qw      the tool in the world, as in a TUM file; any order, any rate
//   sync T                         T: the sender's clock now; answered at once by `sync T H`, H: ours
//   offset S                       our clock minus the sender's, as the sender found it out
//   # ...                          nothing
//
// Listens on 127.0.0.1 only. One sender at a time; it may go and come back. What cannot be read is counted
// and named, never fatal.
//
// Clocks: `own`, the sender's times are of its own clock. It is told by `offset`, or learnt from when lines
// arrive (clock_offset.h: the least delay). `host`: of this computer's, seconds since the epoch. `device`: of
// the camera's.
//
// One thread receives; frames ask from another.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "core/base/clock_offset.h"
#include "core/base/mutex.h"
#include "core/geometry/rigid3.h"
#include "tracking/sources/pose_history.h"

namespace ulf::tracking {

enum class SenderClock { kOwn, kHost, kDevice };

struct PoseStreamOptions {
  int port = 0;  // 0: any that is free
  SenderClock clock = SenderClock::kOwn;
  double max_gap_s = 0.2;
  double wait_s = 0.25;             // that a frame waits for a pose of its time
  double connect_s = 10;            // that the first frame waits for a sender
  double offset_s = 0;              // added to a frame's time before it is looked up
  std::function<bool()> stop = {};  // asked while waiting
};

class PoseStream {
 public:
  // Throws Error when the port cannot be had.
  explicit PoseStream(const PoseStreamOptions& options);
  ~PoseStream();
  PoseStream(const PoseStream&) = delete;
  PoseStream& operator=(const PoseStream&) = delete;

  int Port() const { return port_; }
  // The tool at a frame's time. Waits for it; not again after having waited in vain, until a line has come.
  std::optional<Rigid3> WorldFromTool(double device_time_s, double host_time_s);

  struct Counts {
    std::uint64_t poses = 0, malformed = 0, out_of_order = 0, connections = 0, refused = 0;
    std::uint64_t found = 0, before = 0, in_gap = 0, not_in_time = 0;  // frames
    std::string first_malformed;                                       // with its line's number
    std::optional<double> offset_s;                                    // our clock minus the sender's
  };
  Counts Statistics() const;
  bool Connected() const;

 private:
  void Serve();
  void Take(const std::string& line, int client, std::uint64_t number);
  bool TakePose(const std::string& line);
  std::optional<double> SenderTime(double device_time_s) const ULF_REQUIRES(mutex_);

  PoseStreamOptions options_;
  int listening_ = -1, wake_[2] = {-1, -1};
  int port_ = 0;
  mutable Mutex mutex_;
  ConditionVariable came_;
  PoseHistory history_ ULF_GUARDED_BY(mutex_);
  ClockOffset sender_clock_ ULF_GUARDED_BY(mutex_), device_clock_ ULF_GUARDED_BY(mutex_);
  std::optional<double> told_offset_s_ ULF_GUARDED_BY(mutex_);
  Counts counts_ ULF_GUARDED_BY(mutex_);
  bool connected_ ULF_GUARDED_BY(mutex_) = false;
  bool starved_ ULF_GUARDED_BY(mutex_) = false;  // a frame waited in vain and nothing has come since
  bool ending_ ULF_GUARDED_BY(mutex_) = false;
  std::thread thread_;
};

}  // namespace ulf::tracking
