// The one door to every camera: machine-vision, webcam, tethered, simulated, replayed.
//
// A device is opened by URI (`aravis:ID`, `v4l2:/dev/video0`, `gphoto2:PORT`, `sim:studio?seed=7`,
// `replay:PATH`), started, and asked for frames one by one. The caller owns the loop; devices that have
// threads of their own hide them. Faults that belong to the work (a frame that did not come, an incomplete
// frame, the cable pulled) are values; a device that cannot be opened throws Error with the reason and the
// way out.
//
// What OpenDevice() returns for a live camera goes round one state machine, whatever the camera (see
// reconnecting_device.h):
//
//   kConnected --Start()--> kStreaming --no frames, control lost--> kFaulted --> kReconnecting --> kStreaming
//                                                                                     |
//                                                                       patience over: kLost
//
// A driver (the device behind it) knows kConnected, kStreaming, kEnded and kLost only: it reports the loss
// and is opened anew.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/base/device_uri.h"
#include "core/geometry/camera_model.h"
#include "core/geometry/sensor_window.h"
#include "core/image/frame.h"

namespace ulf {
struct FlatField;  // core/image/flat_field.h
}  // namespace ulf

namespace ulf::acquisition {

struct DeviceInfo {
  std::string uri;
  std::string maker;
  std::string model;
  std::string serial;
  std::string bus;  // "GigEVision", "USB3Vision", "simulated"; "files" where nobody knows the camera
  bool available = true;
  std::string problem;  // why it cannot be opened and what to do; empty when available
};

enum class DeviceState {
  kConnected,  // opened, not started, or stopped
  kStreaming,
  kFaulted,       // no longer answers: Info().problem says what is known
  kReconnecting,  // being looked for and opened again with the same settings
  kEnded,         // replay came to its end: nothing is wrong
  kLost,          // given up; of a driver: to be opened anew
};
const char* Name(DeviceState state);
// No frame will come any more.
inline bool IsOver(DeviceState state) { return state == DeviceState::kEnded || state == DeviceState::kLost; }

// What a device has to say between frames, each said once, in order.
enum class DeviceEventKind {
  kStalled,  // no frame for longer than normal; nothing lost yet
  kFaulted,  // frames are being lost from here on
  kReconnecting,
  kRestored,  // streaming again; the gap is from the last frame before kFaulted to the next frame
  kNotice,    // worth a word: battery low, card full, busy, a setting that the camera changed itself
};
struct DeviceEvent {
  DeviceEventKind kind = DeviceEventKind::kNotice;
  double host_time_s = 0;  // since the epoch
  std::string text;        // for people, with the way out
};
const char* Name(DeviceEventKind kind);

struct DeviceStatistics {
  std::uint64_t delivered = 0;     // handed out complete
  std::uint64_t incomplete = 0;    // arrived with pixels missing
  std::uint64_t dropped = 0;       // complete, but the reader was too slow
  std::uint64_t missing = 0;       // gaps in the device's frame ids
  std::uint64_t out_of_order = 0;  // arrived after a later frame
  std::uint64_t late = 0;          // arrived more than a period after their time
  std::uint64_t reconnects = 0;
  double seconds = 0;       // of streaming
  std::uint64_t bytes = 0;  // of pixels delivered in that time
  // host clock - device clock, the least delay seen, and the spread of the delay (standard deviation) round
  // it; none for a device without a clock.
  std::optional<double> clock_offset_s, clock_jitter_s;
  // The transport's own counters (packets missing, resent, ...), named for people, in the order to be shown.
  std::vector<std::pair<std::string, double>> transport;
};

// Which of a camera's automatics leave the pictures alone from one to the next; none: the camera does not
// tell, or is not known to.
struct HeldAutomatics {
  std::optional<bool> exposure, white_balance, focus;
};

enum class StillRequest { kAsked, kBusy };

class Device {
 public:
  virtual ~Device() = default;
  virtual DeviceInfo Info() const = 0;
  // Intrinsics that the device itself knows (simulator, replayed light field); none for real cameras.
  virtual std::optional<CameraModel> Camera() const { return std::nullopt; }
  // The same of its photographs, where they are known apart.
  virtual std::optional<CameraModel> StillCamera() const { return std::nullopt; }
  // What a recording knows of its camera's light; null: nothing.
  virtual std::shared_ptr<const FlatField> KnownFlatField(FrameKind /*kind*/) const { return nullptr; }
  // True when time passes whether or not frames are taken; false for replay, whose frames wait.
  virtual bool IsLive() const = 0;
  // None: unknown; then an image is taken for the whole sensor.
  virtual std::optional<SensorWindow> Window() const { return std::nullopt; }
  // May change while frames come: automatics may settle first.
  virtual HeldAutomatics Held() const { return {}; }
  virtual void Start() = 0;
  // The next frame, or none within the timeout; then State() says whether to go on asking. Its pixels may be
  // shared and kept: no device writes into them again.
  virtual std::optional<Frame> Next(std::chrono::milliseconds timeout) = 0;
  virtual void Stop() = 0;
  virtual DeviceState State() const = 0;
  virtual DeviceStatistics Statistics() const = 0;
  virtual std::vector<DeviceEvent> TakeEvents() { return {}; }
  // How much of a recording has been played, 0 to 1; none for what has no end.
  virtual std::optional<double> ShareDone() const { return std::nullopt; }

  // Photographs besides the live frames (tethered cameras): asked for here, they come through Next() as
  // FrameKind::kStill when they have been downloaded, also those that the photographer releases on the body.
  virtual bool TakesStills() const { return false; }
  virtual StillRequest RequestStill() { return StillRequest::kBusy; }
};

// Opens by scheme; an empty URI means the first real camera found. Throws UsageError for a URI that means
// nothing, Error for a device that cannot be opened.
std::unique_ptr<Device> OpenDevice(const std::string& uri);

// Every camera in reach, real ones first, then the simulated one that is always there. Takes about a second.
std::vector<DeviceInfo> ListDevices();

}  // namespace ulf::acquisition
