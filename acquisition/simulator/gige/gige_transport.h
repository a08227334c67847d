// What Aravis's camera side lacks of a GigE Vision camera: the pause between packets (GevSCPD), a limit of
// its own throughput (DeviceLinkThroughputLimit), chunk data, and a clock that IEEE 1588 sets.
//
// Aravis sends the stream itself as long as none of these is in use. Else, from AcquisitionStart to
// AcquisitionStop, its stream goes to a socket that nobody reads, and the frames are sent from here.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>

#include "acquisition/simulator/gige/gige_registers.h"
#include "acquisition/simulator/gige/gvcp_filter.h"
#include "acquisition/simulator/gige/gvsp_sender.h"

namespace ulf::acquisition {

struct SimulatedClock {
  double ahead_s = 0;  // of this computer's, until IEEE 1588 sets it
  // From PtpEnable to PtpStatus Slave, and from a master that comes back; negative: there is no master.
  double ptp_lock_s = 1;
  bool forgets_chunks = false;  // the camera announces chunk data and sends none
};

// What the chunk data of a frame say.
struct ChunkValues {
  double exposure_us = 0, gain_db = 0;
  std::uint64_t frame_id = 0, lines = 0;
};

class GigeTransport {
 public:
  // `stream_socket`: Aravis's, bound to the camera's address; owned by this object.
  GigeTransport(int stream_socket, const std::string& camera_address, RegisterAccess registers,
                const SimulatedClock& clock);
  ~GigeTransport();
  GigeTransport(const GigeTransport&) = delete;
  GigeTransport& operator=(const GigeTransport&) = delete;

  // Before Aravis gets a request that was found valid.
  void BeforeRequest(const GvcpAccess& access);
  // Whether there is an IEEE 1588 master from now on. Without one a clock that was set drifts.
  void HearMaster(bool heard);
  // The camera's clock at a time of this computer's.
  std::uint64_t ClockNs(std::uint64_t host_ns) const;
  // Before the camera takes the next frame: the last one must have left.
  void WaitUntilSent(std::chrono::milliseconds patience);
  // Whether frames are sent from here, until the client stops the acquisition.
  bool Sends() const;
  // Sends the frame with the chunk data that are switched on, where Sends(). `timestamp_ns`: ClockNs().
  void Send(GvspFrame frame, const ChunkValues& chunks);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace ulf::acquisition
