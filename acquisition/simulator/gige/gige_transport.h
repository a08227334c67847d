// Streams the frames of the simulated camera to where the registers say, with the pause between packets
// (GevSCPD), the throughput (DeviceLinkThroughputLimit) and the chunk data that a client has set, timed by a
// clock that IEEE 1588 (PTP) sets.
#pragma once

#include <chrono>
#include <cstdint>

#include "acquisition/simulator/gige/gige_registers.h"
#include "acquisition/simulator/gige/gvcp_server.h"
#include "acquisition/simulator/gige/gvsp_sender.h"
#include "acquisition/simulator/gige/register_memory.h"
#include "core/base/file_descriptor.h"
#include "core/base/mutex.h"

namespace ulf::acquisition {

struct SimulatedClock {
  double ahead_s = 0;  // of this computer's clock, until PTP sets it
  // From PtpEnable, or from a master that comes back, to PtpStatus Slave; negative: there is no master.
  double ptp_lock_s = 1;
  bool forgets_chunks = false;  // the camera announces chunk data and sends none
};

// What the chunk data of a frame say; `lines`: states of the input lines, one bit each.
struct ChunkValues {
  double exposure_us = 0, gain_db = 0;
  std::uint64_t frame_id = 0, lines = 0;
};

class GigeTransport {
 public:
  // `stream_socket`: bound to the camera's address.
  GigeTransport(FileDescriptor stream_socket, RegisterMemory& memory, const SimulatedClock& clock);

  // Call it before a valid request is carried out.
  void BeforeRequest(const GvcpAccess& access);
  // Sets whether there is a PTP master from now on. Without one a clock that was set drifts.
  void HearMaster(bool heard);
  // Returns the camera's clock at a time of this computer's.
  std::uint64_t ClockNs(std::uint64_t host_ns) const;
  // Waits until the last frame has left. Call it before the camera takes the next one.
  void WaitUntilSent(std::chrono::milliseconds patience) { sender_.WaitUntilSent(patience); }
  // Sends the frame with the chunk data that are switched on. GvspFrame::timestamp_ns: from ClockNs().
  void Send(GvspFrame frame, const ChunkValues& chunks);

 private:
  bool FollowsMaster() const ULF_REQUIRES(mutex_) { return ptp_on_ && has_master_; }
  bool IsSet() const ULF_REQUIRES(mutex_);
  std::int64_t AheadNs() const ULF_REQUIRES(mutex_);
  std::uint32_t PtpStatus() const ULF_REQUIRES(mutex_);
  // Sets whether IEEE 1588 is on and whether a master is there: the camera follows the master if both hold.
  void Switch(bool on, bool master) ULF_REQUIRES(mutex_);

  RegisterMemory& memory_;
  const SimulatedClock clock_;
  GvspSender sender_;
  mutable Mutex mutex_;
  bool ptp_on_ ULF_GUARDED_BY(mutex_) = false, has_master_ ULF_GUARDED_BY(mutex_);
  std::uint64_t follows_since_ns_ ULF_GUARDED_BY(mutex_) = 0;  // of a camera that follows a master
  std::uint64_t drifts_since_ns_ ULF_GUARDED_BY(mutex_) = 0;   // of a clock that was set; 0: it was not
};

}  // namespace ulf::acquisition
