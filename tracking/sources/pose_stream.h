// Receives poses that another program sends over a socket of this computer: a robot's controller, a
// motion-capture bridge. The sender writes lines of text (docs/tracking.md describes them for senders):
//
//   time tx ty tz qx qy qz qw      the tool's pose in the world, as in a TUM file; in any order, at any rate
//   sync T                         T: the sender's clock now; the answer is `sync T H`, H: our clock
//   offset S                       our clock minus the sender's, as the sender measured it
//   # ...                          a comment
//
// The stream listens on 127.0.0.1 only, to one sender at a time, which may leave and return. Lines that
// cannot be read are counted, and the first is reported. One thread receives, another asks for poses.
//
// `time` is by one of these clocks, in seconds:
//   own       the sender's. `offset` gives the difference to ours, or the arrival times do (clock_offset.h:
//             the least delay)
//   host      this computer's, since the epoch
//   device    the camera's
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <thread>
#include <variant>

#include "core/base/clock_offset.h"
#include "core/base/file_descriptor.h"
#include "core/base/mutex.h"
#include "core/geometry/rigid3.h"
#include "tracking/sources/pose_history.h"

namespace ulf::tracking {

enum class SenderClock { kOwn, kHost, kDevice };

// A line that a sender may write.
struct SentPose {
  double time_s = 0;  // by the sender's clock
  Rigid3 world_from_tool;
};
struct SentSync {
  double sender_s = 0;
};
struct SentOffset {
  double offset_s = 0;  // our clock minus the sender's
};
struct SentComment {};  // also an empty line
using SentLine = std::variant<SentComment, SentPose, SentSync, SentOffset>;

// Parses a line without its end. Returns none for another form, or a number that is not finite.
std::optional<SentLine> ReadSentLine(const std::string& line);

struct PoseStreamOptions {
  int port = 0;  // 0: any that is free
  SenderClock clock = SenderClock::kOwn;
  double max_gap_s = 0.2;           // between poses that are farther apart there is none
  double wait_s = 0.25;             // how long a frame waits for a pose of its time
  double connect_s = 10;            // how long the first frame waits for the first pose
  double offset_s = 0;              // added to a frame's time before it is looked up
  std::function<bool()> stop = {};  // returns true to end waiting
};

class PoseStream {
 public:
  // Throws Error if it cannot listen on the port.
  explicit PoseStream(const PoseStreamOptions& options);
  ~PoseStream();
  PoseStream(const PoseStream&) = delete;
  PoseStream& operator=(const PoseStream&) = delete;

  int Port() const { return port_; }
  // Returns the tool's pose at a frame's time by the camera's clock; `host_time_s` is the same by ours, since
  // the epoch. Waits for a pose of that time while a sender is connected; after a wait in vain, not again
  // until another pose has come. Returns none if there is none.
  std::optional<Rigid3> WorldFromTool(double device_time_s, double host_time_s);

  struct Counts {
    std::uint64_t poses = 0, malformed = 0, out_of_order = 0, connections = 0, refused = 0;
    std::uint64_t found = 0, before = 0, in_gap = 0, not_in_time = 0;  // of frames, by what became of them
    std::string first_malformed;                                       // the line, with its number
    std::optional<double> offset_s;                                    // our clock minus the sender's
  };
  Counts Statistics() const;
  bool Connected() const;

 private:
  void Serve();
  void Take(const std::string& line, int client, std::uint64_t number);
  void TakePose(const SentPose& sent);
  std::optional<double> SenderTime(double device_time_s) const ULF_REQUIRES(mutex_);
  std::optional<double> SenderOffset() const ULF_REQUIRES(mutex_);  // our clock minus the sender's

  PoseStreamOptions options_;
  FileDescriptor listening_, wake_read_, wake_write_;
  int port_ = 0;
  mutable Mutex mutex_;
  ConditionVariable changed_;
  PoseHistory history_ ULF_GUARDED_BY(mutex_);
  ClockOffset sender_clock_ ULF_GUARDED_BY(mutex_), device_clock_ ULF_GUARDED_BY(mutex_);
  std::optional<double> given_offset_s_ ULF_GUARDED_BY(mutex_);
  Counts counts_ ULF_GUARDED_BY(mutex_);
  bool connected_ ULF_GUARDED_BY(mutex_) = false;
  bool timed_out_ ULF_GUARDED_BY(mutex_) = false;  // a frame waited in vain, and no pose has arrived since
  bool ending_ ULF_GUARDED_BY(mutex_) = false;
  std::thread thread_;
};

}  // namespace ulf::tracking
