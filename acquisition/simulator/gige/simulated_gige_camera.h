// The simulated camera as a real GigE Vision device on a network address: discovery, GenICam description,
// control and streaming are Aravis's camera-side classes; what the sensor sees is ours. ExposureTime, Gain,
// PixelFormat, Width, Height, offsets and AcquisitionFrameRate act on the picture.
//
// Time is real: the hand moves as long as frames are taken and rests while nobody streams. Frames are
// rendered ahead into a ring, for the moments at which the camera will fire (Aravis fires at multiples of the
// frame period of the system clock). When the renderer falls behind, the camera fires late and skips moments,
// as a real one with too long an exposure would; a changed setting empties the ring. A loop of pictures,
// rendered before and played to and fro, costs next to nothing and keeps any pace.
//
// Formats: all of SensorFormat. Trigger: TriggerMode On with TriggerSource Software or Line0; on Line0 a
// pulse comes LinePulseRate times a second, as long as frames may be taken. Two software triggers closer
// together than the camera takes to send a frame give one frame, as they do on cameras without a trigger
// buffer.
//
// Aravis's camera side knows no chunk data. Instead the last frame's own facts stand in registers:
// LastFrameId (as sent: 16 bits), LastFrameNumber (counted from 1, never wraps), LastExposureTime, LastGain,
// LastHandTime. All five change together, before the first packet of the frame leaves.
//
// The network reaches the library's camera side through a door (gvcp_filter.h), which answers junk with the
// protocol's status codes; the stream leaves without a detour.
//
// Faults of the link and of time make a relay stand before the camera (gige_relay.h); the camera itself then
// hides at another address (gige_address.h).
//
// The pose file, when asked for, is TUM's format: `timestamp tx ty tz qx qy qz qw`, camera to world, metres;
// the timestamp is the frame's as its client sees it (start of exposure, seconds of the device's clock) while
// the pose is that of the middle of the exposure. Before each pose stands a comment line `# frame ID hand_s
// T`, which TUM's readers skip. Every pose is flushed before the first packet of its frame leaves.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include "acquisition/simulator/gige/gige_relay.h"
#include "acquisition/simulator/simulated_camera.h"

namespace ulf::acquisition {

struct GigeServerOptions {
  SimulationOptions simulation;
  std::string interface = "127.0.0.1";  // an IPv4 address of this machine; one camera per address
  std::string serial = "ULF-SIM-1";
  std::filesystem::path poses;  // empty: not written
  double line_hz = 10;          // pulses on Line0 at first
  int loop = 0;                 // pictures in the loop; 0: rendered as the hand goes
};

struct GigeServerStatistics {
  std::uint64_t served = 0;  // frames handed to the network
  std::uint64_t late = 0;    // of those, sent after their moment because rendering had fallen behind
  double render_ms_mean = 0;
  double hand_s = 0;          // how far the hand has come
  std::uint64_t refused = 0;  // requests that got a status code instead of what they asked for
};

class SimulatedGigeCamera {
 public:
  // Serves when it returns. Throws Error when the address is not this machine's, when another camera already
  // answers there, or when nothing answers by our serial.
  explicit SimulatedGigeCamera(const GigeServerOptions& options);
  ~SimulatedGigeCamera();
  SimulatedGigeCamera(const SimulatedGigeCamera&) = delete;
  SimulatedGigeCamera& operator=(const SimulatedGigeCamera&) = delete;

  // As Aravis lists it: "Vendor-Serial".
  std::string DeviceId() const;
  const SimulatedCamera& camera() const;
  GigeServerStatistics Statistics() const;
  // None when no fault asked for a relay. A freeze of no length, `freeze=0:0`,
  // brings it in for tests that break the link by hand.
  GigeRelay* relay();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace ulf::acquisition
