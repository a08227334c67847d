// Serves the simulated camera as a GigE Vision device on a network address. ExposureTime, Gain, PixelFormat,
// Width, Height, offsets and AcquisitionFrameRate affect the image.
//
// Time is real: the hand moves while a client streams and rests otherwise. Frames are rendered ahead into a
// ring, for the times at which the camera will fire: multiples of the frame period of the system clock. When
// rendering falls behind, the camera fires late and skips frames, as a real camera with too long an exposure
// does. A changed setting empties the ring. A loop of pictures that are rendered at the start and played
// forwards and backwards (`loop`) reaches any frame rate.
//
// Formats: all of SensorFormat. Trigger: TriggerMode On with TriggerSource Software or Line0; Line0 gets
// LinePulseRate pulses per second. Two software triggers within the time that the camera needs to send a
// frame give one frame, as on cameras without a trigger buffer.
//
// Registers describe the last frame: LastFrameId (as sent: 16 bits), LastFrameNumber (from 1, never wraps),
// LastExposureTime (us), LastGain (tenths of dB), LastHandTime (ms). All five change together, before the
// first packet of the frame is sent.
//
// One thread answers control requests (gvcp_server.h) and takes frames: requests wait while a frame is
// rendered, and registers that are read in one request describe one frame. Another sends (gige_transport.h).
//
// Faults of the link and of time need a relay (gige_relay.h) at the camera's address; the camera itself then
// has another one (gige_address.h).
//
// The pose file has TUM's format: `timestamp tx ty tz qx qy qz qw`, camera to world, metres. The timestamp is
// that of the frame at its client (start of exposure, seconds of the device's clock); the pose is that of the
// middle of the exposure. A comment line `# frame ID hand_s T`, which readers of the format skip, precedes
// each pose. Every pose is flushed before the first packet of its frame is sent.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "acquisition/simulator/gige/gige_relay.h"
#include "acquisition/simulator/gige/gige_transport.h"
#include "acquisition/simulator/simulated_board.h"
#include "acquisition/simulator/simulated_camera.h"

namespace ulf::acquisition {

struct GigeServerOptions {
  SimulationOptions simulation;
  // A board or card that is held before the camera, instead of the simulation's scene and hand. Its pictures
  // must have the simulation's size.
  std::optional<BoardSceneOptions> board = {};
  std::string interface = "127.0.0.1";  // an IPv4 address of this machine; one camera per address
  std::string serial = "ULF-SIM-1";
  std::filesystem::path poses;  // empty: not written
  double line_hz = 10;          // LinePulseRate at the start
  int loop = 0;                 // pictures in the loop; 0: every frame is rendered
  SimulatedClock clock = {};
};

struct GigeServerStatistics {
  std::uint64_t served = 0;  // frames sent
  std::uint64_t late = 0;    // of those, frames sent late because rendering fell behind
  double render_ms_mean = 0;
  double hand_s = 0;                  // time of the hand's motion
  std::uint64_t refused = 0;          // requests that were not carried out
  std::uint64_t unwritten_poses = 0;  // of the frames that were sent
};

class SimulatedGigeCamera {
 public:
  // The camera runs when the constructor returns. Throws Refusal for options that are out of range or
  // contradict each other, Error if the address is not this machine's, another camera uses it, or the camera
  // does not answer there.
  explicit SimulatedGigeCamera(const GigeServerOptions& options);
  ~SimulatedGigeCamera();
  SimulatedGigeCamera(const SimulatedGigeCamera&) = delete;
  SimulatedGigeCamera& operator=(const SimulatedGigeCamera&) = delete;

  // Returns Aravis's name of the camera: "Vendor-Serial".
  std::string DeviceId() const;
  const SimulatedCamera& camera() const;  // not with a board
  CameraModel StoredCamera() const;       // the intrinsics of a calibration
  GigeServerStatistics Statistics() const;
  // Returns null without a fault that needs a relay. The fault `freeze=0:0`, a freeze without length, makes a
  // relay for tests that control the link.
  GigeRelay* relay();
  // Sets whether there is an IEEE 1588 master from now on, as the fault ptp_lost does at given times.
  void HearMaster(bool heard);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace ulf::acquisition
