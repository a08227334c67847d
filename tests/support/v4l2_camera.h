// Emulates a webcam: a kernel video node through umockdev, with formats, controls, buffers and faults, for
// programs that know nothing of the emulation. Its buffers are mapped memory, its frames come in time.
//
// The emulation works in a process (or its children) that runs under umockdev's preloaded library;
// NoV4l2Emulation() tells why it cannot. There is one webcam at a time.
#pragma once

#include <linux/videodev2.h>

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace ulf::test {

// Returns why there can be no emulated camera in this process; none: there can.
std::optional<std::string> NoV4l2Emulation();

struct EmulatedMode {
  std::uint32_t fourcc = V4L2_PIX_FMT_YUYV;
  std::uint32_t width = 64, height = 48;
  std::vector<std::uint32_t> fps{100};
};

struct EmulatedControl {
  std::uint32_t id = 0;
  std::string title;
  v4l2_ctrl_type type = V4L2_CTRL_TYPE_INTEGER;
  int min = 0, max = 100, step = 1, value = 0;
  std::map<int, std::string> menu = {};
  int refuses = 0;  // the errno that setting it gives; 0: none
};

// What becomes of a frame on its way.
enum class EmulatedFate {
  kArrives,
  kLost,     // its number passes, nothing arrives
  kDamaged,  // it arrives marked as damaged
  kCut,      // its second half is missing
};

struct V4l2CameraOptions {
  std::string node = "video0";
  std::string maker = "Test Optics", card = "Test Webcam", serial = "T1234";
  std::vector<EmulatedMode> modes{{}};
  std::vector<EmulatedControl> controls = {};
  bool takes_user_pointers = true;
  std::uint32_t row_padding = 0;  // bytes after every row
  std::uint32_t colorspace = V4L2_COLORSPACE_SRGB, quantization = V4L2_QUANTIZATION_DEFAULT;
  std::uint32_t timestamp_flags = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC | V4L2_BUF_FLAG_TSTAMP_SRC_SOE;
  // Returns the bytes of frame `sequence`; none: Ramp().
  std::function<std::vector<std::uint8_t>(const EmulatedMode&, std::uint32_t sequence)> render = {};
  std::function<EmulatedFate(std::uint32_t sequence)> fate = {};  // none: all arrive
};

// Returns an auto exposure that is on, its time, and others a webcam has. While auto exposure is on, the time
// moves by one step with every frame, from 100, and cannot be set.
std::vector<EmulatedControl> UsualControls();

class EmulatedV4l2Camera {
 public:
  explicit EmulatedV4l2Camera(const V4l2CameraOptions& options = {});
  ~EmulatedV4l2Camera();
  EmulatedV4l2Camera(const EmulatedV4l2Camera&) = delete;
  EmulatedV4l2Camera& operator=(const EmulatedV4l2Camera&) = delete;

  void Unplug();  // as the kernel does it: the node is gone, and who has it open is told so
  void PlugIn();
  void SkipFrames(std::uint32_t count);    // the next so many: their numbers pass, nothing arrives
  void DamageFrames(std::uint32_t count);  // the next so many arrive marked as damaged
  void HoldBack(bool hold);                // true: no frames at all
  void SetBusy(bool busy);                 // as if another program streamed
  int Control(std::uint32_t id) const;     // its present value
  bool IsStreaming() const;
  std::uint32_t Memory() const;  // V4L2_MEMORY_...: the kind of the buffers last asked for
  // Returns the default picture, a ramp that moves by one with every frame.
  static std::vector<std::uint8_t> Ramp(const EmulatedMode& mode, std::uint32_t sequence);
  static std::size_t RowBytes(const EmulatedMode& mode);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace ulf::test
