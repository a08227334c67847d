// Defines the interface of every camera: machine-vision, webcam, tethered, simulated, replayed.
//
// OpenDevice() (opening/open_device.h) opens a device by its URI. The caller starts it and asks for frames
// one by one; threads inside a device are hidden. Faults during operation (a frame that did not arrive, an
// incomplete frame, a pulled cable) are values. Opening throws Error with the reason and the remedy.
//
// Every live camera that OpenDevice() returns follows one state machine (reconnecting_device.h):
//
//   kConnected --Start()--> kStreaming --no frames, control lost--> kFaulted --> kReconnecting --> kStreaming
//                                                                                     |
//                                                             not found within patience_s: kLost
//
// That device wraps a driver, which knows one library or protocol. A driver has the states kConnected,
// kStreaming, kEnded and kLost only: it reports the loss, and a new driver is opened.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "acquisition/device/transport_figures.h"
#include "core/base/device_uri.h"
#include "core/base/error.h"
#include "core/frames/frame.h"
#include "core/geometry/camera_model.h"
#include "core/geometry/sensor_window.h"

namespace ulf {
struct FlatField;     // core/image/flat_field.h
struct ColorProfile;  // core/image/color_profile.h
}  // namespace ulf

namespace ulf::acquisition {

struct DeviceInfo {
  std::string uri;  // opens the same camera with the same settings
  std::string maker;
  std::string model;
  std::string serial;
  std::string bus;  // "GigEVision", "USB", ..., or a webcam's bus path; "files" when the camera is unknown
  bool available = true;
  std::string problem;       // why it cannot be opened or was lost, and what to do; empty when available
  std::string remark = {};   // what slows the camera, or what is special about a replay's files; mostly empty
  std::string address = {};  // IPv4, of a camera in a network
  double pixel_aspect = 1;   // width of a pixel over its height; only some videos differ from 1
};

enum class DeviceState {
  kConnected,  // opened, not started, or stopped
  kStreaming,
  kFaulted,       // no longer answers; the reason is in Info().problem
  kReconnecting,  // being searched for and opened again with the same settings
  kEnded,         // a replay or simulation reached its end; no error
  kLost,          // given up; a driver must be opened again
};
const char* Name(DeviceState state);
// Returns whether no frame will come any more in this state.
inline bool IsOver(DeviceState state) { return state == DeviceState::kEnded || state == DeviceState::kLost; }

// A device reports one of these between frames.
enum class DeviceEventKind {
  kStalled,  // no frame for longer than normal; nothing lost yet
  kFaulted,  // frames are being lost from here on
  kReconnecting,
  kRestored,  // streaming again; the gap is from the last frame before kFaulted to the next frame
  kNotice,    // for information: battery low, card full, busy, a setting that the camera changed itself
};
struct DeviceEvent {
  DeviceEventKind kind = DeviceEventKind::kNotice;
  double host_time_s = 0;  // since the epoch
  std::string text;        // for people, with the remedy
  // Seconds without a frame, for kStalled and for the kNotice that frames arrive again; else 0.
  double silence_s = 0;
};
const char* Name(DeviceEventKind kind);

struct DeviceStatistics {
  std::uint64_t delivered = 0;     // complete frames that Next() returned
  std::uint64_t incomplete = 0;    // arrived with pixels missing
  std::uint64_t dropped = 0;       // complete, but the reader was too slow
  std::uint64_t missing = 0;       // never arrived, by gaps in the device's frame ids
  std::uint64_t out_of_order = 0;  // arrived after a later frame
  std::uint64_t late = 0;          // delayed by more than a frame period above the least delay
  std::uint64_t reconnects = 0;
  double seconds = 0;       // of streaming
  std::uint64_t bytes = 0;  // of pixels delivered in that time
  // Host clock minus device clock, seconds, at the least delay of a frame, and the standard deviation of the
  // delay; none for a device without a clock.
  std::optional<double> clock_offset_s, clock_jitter_s;
  TransportFigures transport;  // packets missing, resent, ...
};

// Whether exposure, white balance and focus are held from picture to picture; none: unknown.
struct HeldAutomatics {
  std::optional<bool> exposure, white_balance, focus;
};

// kBusy: the request is ignored, because an earlier one is still to be answered, or the device cannot.
enum class StillRequest { kAsked, kBusy };

// How a device takes the exposures of RequestExposures().
enum class ExposureRequests {
  kNone,       // the device cannot
  kSequencer,  // the camera changes its exposure time by itself, from frame to frame
  kSetTime,    // the device sets the exposure time, and waits for a frame that has it
};

class Device {
 public:
  virtual ~Device() = default;
  virtual DeviceInfo Info() const = 0;
  // Returns the intrinsics of live frames if the device knows them (simulator, replay), or none.
  virtual std::optional<CameraModel> Camera() const { return std::nullopt; }
  // Returns the intrinsics of photographs, if they differ.
  virtual std::optional<CameraModel> StillCamera() const { return std::nullopt; }
  // Returns the flat field that a recording contains; null if there is none.
  virtual std::shared_ptr<const FlatField> KnownFlatField(FrameKind /*kind*/) const { return nullptr; }
  // Returns the colour profile that a recording contains; null if there is none.
  virtual std::shared_ptr<const ColorProfile> KnownColorProfile(FrameKind /*kind*/) const { return nullptr; }
  // Returns true when frames arrive whether or not Next() is called; false when they wait for it, as those of
  // a replay and of the simulator.
  virtual bool IsLive() const = 0;
  // Returns what the user can still change about the frames, which decides what messages advise.
  virtual FrameSource Source() const { return FrameSource::kCamera; }
  // Returns false once no live frame can come any more, as from a tethered camera without live view.
  virtual bool HasLiveFrames() const { return true; }
  // Returns the part of the sensor that the image shows; none if unknown: callers assume the whole sensor.
  virtual std::optional<SensorWindow> Window() const { return std::nullopt; }
  // Returns what is held. It may change while frames arrive, because automatics may settle first.
  virtual HeldAutomatics Held() const { return {}; }
  virtual void Start() = 0;  // throws Error
  // Returns the next frame; none if none comes within the timeout (State() tells whether more can come). The
  // caller may keep and share its pixels: no device writes into them again. Only a replay throws Error, for a
  // file that it cannot read.
  virtual std::optional<Frame> Next(std::chrono::milliseconds timeout) = 0;
  virtual void Stop() = 0;
  virtual DeviceState State() const = 0;
  virtual DeviceStatistics Statistics() const = 0;
  // Returns the events since the last call, in their order.
  virtual std::vector<DeviceEvent> TakeEvents() { return {}; }
  // Returns the part of a recording that has been played, 0 to 1; none for a device without an end.
  virtual std::optional<double> ShareDone() const { return std::nullopt; }

  // Tethered cameras take photographs besides live frames. Next() returns them as FrameKind::kStill after
  // their download, including those that the photographer releases on the camera body.
  virtual bool TakesStills() const { return false; }
  virtual StillRequest RequestStill() { return StillRequest::kBusy; }

  // The first function tells how the device takes a bracket, the second requests one: exposures that are each
  // so many stops longer (negative: shorter) than the present one, in this order, then the present one again.
  // Each arrives as a frame (of a tethered camera as a photograph) with Frame::asked_stops; frames between
  // them have their own exposure_s (0: unknown). The camera takes the nearest exposure that it can, and
  // reports one that it cannot take as a kNotice.
  virtual ExposureRequests TakesExposures() const { return ExposureRequests::kNone; }
  virtual StillRequest RequestExposures(const std::vector<double>& /*stops*/) { return StillRequest::kBusy; }
};

inline std::chrono::steady_clock::duration DurationOf(double seconds) {
  return std::chrono::duration_cast<std::chrono::steady_clock::duration>(
      std::chrono::duration<double>(seconds));
}

// Return a refusal without a value, "WHAT: WHY; REMEDY"; WHAT is a device or its URI.
inline Refusal Refused(const std::string& what, const std::string& why, const std::string& remedy = "") {
  return {what, "", why, remedy};
}
inline Refusal Refused(const DeviceUri& uri, const std::string& why, const std::string& remedy = "") {
  return Refused(fmt::format("'{}'", uri.Text()), why, remedy);
}

// Throws Error if no live frames will ever come, with the alternative: photographs, to be posed afterwards.
void RequireLiveFrames(const Device& device);

}  // namespace ulf::acquisition
