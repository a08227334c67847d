// The one door to every camera: machine-vision, simulated, replayed.
//
// A device is opened by URI (`sim:studio?seed=7`, `replay:PATH`, `aravis:ID`), started, and asked for frames
// one by one. The caller owns the loop; devices that have threads of their own hide them. Faults that belong
// to the work (a frame that did not come, an incomplete frame, the cable pulled) are values; a device that
// cannot be opened throws Error with the reason and the way out.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/camera_model.h"
#include "acquisition/frame.h"

namespace ulf {

struct DeviceInfo {
  std::string uri;
  std::string maker;
  std::string model;
  std::string serial;
  std::string bus;  // "GigEVision", "USB3Vision", "simulated", "files"
  bool available = true;
  std::string problem;  // why it cannot be opened and what to do; empty when available
};

enum class DeviceState {
  kStreaming,
  kEnded,  // replay came to its end: nothing is wrong
  kLost,   // the device no longer answers
};

struct DeviceStatistics {
  std::uint64_t delivered = 0;   // handed out complete
  std::uint64_t incomplete = 0;  // arrived with pixels missing
  std::uint64_t dropped = 0;     // complete, but the reader was too slow
  std::uint64_t missing = 0;     // gaps in the device's frame ids
};

class Device {
 public:
  virtual ~Device() = default;
  virtual DeviceInfo Info() const = 0;
  // Intrinsics that the device itself knows (simulator, replayed light field); none for real cameras.
  virtual std::optional<CameraModel> Camera() const { return std::nullopt; }
  // True when time passes whether or not frames are taken; false for replay, whose frames wait.
  virtual bool IsLive() const = 0;
  virtual void Start() = 0;
  // The next frame, or none within the timeout; then State() says whether to go on asking.
  virtual std::optional<Frame> Next(std::chrono::milliseconds timeout) = 0;
  virtual void Stop() = 0;
  virtual DeviceState State() const = 0;
  virtual DeviceStatistics Statistics() const = 0;
};

// A device URI taken apart: `scheme:path?key=value&key=value`.
struct DeviceUri {
  std::string scheme;
  std::string path;
  std::vector<std::pair<std::string, std::string>> options;

  static DeviceUri Parse(const std::string& uri);  // throws UsageError
  std::optional<std::string> Option(const std::string& key) const;
  // The option as a finite number; throws UsageError naming it when it is something else.
  std::optional<double> Number(const std::string& key) const;
  // Throws UsageError naming the first option that is not in `known`.
  void AllowOnly(const std::vector<std::string>& known) const;
  std::string Text() const;
};

// Opens by scheme; an empty URI means the first real camera found. Throws UsageError for a URI that means
// nothing, Error for a device that cannot be opened.
std::unique_ptr<Device> OpenDevice(const std::string& uri);

// Every camera in reach, real ones first, then the simulated one that is always there. Takes about a second.
std::vector<DeviceInfo> ListDevices();

}  // namespace ulf
