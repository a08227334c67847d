// Emulates a USB3 Vision camera: the control protocol over its control endpoint (registers of the bootstrap
// map, a manifest with a zipped GenICam description), leader, payload and trailer over its streaming
// endpoint, on an emulated USB device (usb_node.h). The client is any library over libusb.
//
// The emulation works in a process that runs under the preloaded libraries; NoUsbEmulation() tells why it
// cannot.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>

#include "tests/support/usb/usb_node.h"

namespace ulf::test {

// What becomes of a frame on its way.
enum class U3vFate {
  kArrives,
  kLost,          // its number passes, nothing arrives
  kCut,           // the second half of its payload is missing
  kNoTrailer,     // the next frame's leader follows its payload
  kShortTrailer,  // a trailer of four bytes
  kBadTrailer,    // whose status is an error
  kNoLeader,      // it begins with the payload
  kNoChunks,      // sent without the chunk data that are switched on
};

// What the camera answers to a request of its control channel.
enum class U3vAnswer {
  kAnswers,
  kSilent,      // nothing
  kPending,     // that it needs longer, then after that the answer
  kOtherFirst,  // first an answer to another request
  kRefuses,     // an error
};

struct U3vFrame {
  std::uint64_t id = 0;
  std::uint32_t width = 0, height = 0, x = 0, y = 0, pixel_format = 0;
};

struct U3vOptions {
  std::string maker = "Test Optics", model = "Test U3V", serial = "U1";
  std::string port = "1";  // UsbIdentity::port
  int megabits = 5000;     // 480: a port or a cable of USB 2
  std::uint32_t sensor_width = 1280, sensor_height = 1024;
  int alignment_bits = 10;      // transfers are multiples of 2 to the power of it
  bool zipped = true;           // the description
  bool event_interface = true;  // one for events lies between those for control and streaming
  bool keeps_pace = true;       // frames that the host does not ask for in time are lost; false: they wait
  // Returns the bytes of a frame without padding; none: Ramp().
  std::function<Bytes(const U3vFrame&)> render = {};
  std::function<U3vFate(std::uint64_t id)> fate = {};                       // none: all arrive
  std::function<U3vAnswer(std::uint64_t address, bool write)> answer = {};  // none: all are answered
  // What is replaced in the description before it is stored, and by what.
  std::map<std::string, std::string> edits = {};
};

class EmulatedU3vCamera {
 public:
  explicit EmulatedU3vCamera(const U3vOptions& options = {});
  ~EmulatedU3vCamera();
  EmulatedU3vCamera(const EmulatedU3vCamera&) = delete;
  EmulatedU3vCamera& operator=(const EmulatedU3vCamera&) = delete;

  UsbNode& Node() const;
  void Unplug();  // the cable: what the camera was set to is lost
  void PlugIn();
  void StallStream();        // the streaming endpoint halts, until the host clears that
  void HoldBack(bool hold);  // true: no frames at all
  // Replace U3vOptions::fate and U3vOptions::answer.
  void Fate(std::function<U3vFate(std::uint64_t id)> fate);
  void Answer(std::function<U3vAnswer(std::uint64_t address, bool write)> answer);

  bool IsAcquiring() const;
  std::uint64_t Exposed() const;   // how many frames since it was plugged in
  std::uint64_t Requests() const;  // how many came to the control channel
  std::uint32_t Register(std::uint64_t address) const;
  double RealRegister(std::uint64_t address) const;

  // Returns the default picture: the low bits of 3x + 5y + id in the format's packing, by sensor coordinates.
  static Bytes Ramp(const U3vFrame& frame);
  static std::size_t ImageBytes(const U3vFrame& frame);

  // Addresses of registers, for tests that look.
  static constexpr std::uint64_t kSpeed = 0x1040, kStreamControl = 0x1104, kWidth = 0x2000,
                                 kTriggerMode = 0x201c, kTriggerSoftware = 0x2024, kChunkMode = 0x202c,
                                 kExposure = 0x2050, kGain = 0x2058, kFrameRate = 0x2060,
                                 kThroughputLimit = 0x2070;
  static constexpr std::uint8_t kControlIn = 0x81, kControlOut = 0x01, kStreamIn = 0x83;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace ulf::test
