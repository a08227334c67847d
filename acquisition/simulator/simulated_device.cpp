#include "acquisition/simulator/simulated_device.h"

#include "acquisition/simulator/simulated_board.h"
#include "acquisition/simulator/simulated_camera.h"

namespace ulf {
namespace {

class SimulatedDevice : public Device {
 public:
  explicit SimulatedDevice(const DeviceUri& uri) : uri_(uri), camera_(SimulationOptions::FromUri(uri)) {}

  DeviceInfo Info() const override {
    return {.uri = uri_.Text(),
            .maker = "ULF",
            .model = "simulated hand-held camera",
            .serial = "sim-" + camera_.options().scene + "-" + std::to_string(camera_.options().seed),
            .bus = "simulated",
            .problem = {}};
  }
  std::optional<CameraModel> Camera() const override { return camera_.camera(); }
  bool IsLive() const override { return false; }
  void Start() override { started_ = true; }
  void Stop() override { started_ = false; }

  std::optional<Frame> Next(std::chrono::milliseconds /*timeout*/) override {
    if (!started_ || State() != DeviceState::kStreaming) return std::nullopt;
    Frame frame = camera_.Capture(next_++);
    frame.host_time_s =
        std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
    ++statistics_.delivered;
    return frame;
  }

  DeviceState State() const override {
    const bool over = static_cast<double>(next_) / camera_.options().fps >= camera_.options().duration_s;
    return over ? DeviceState::kEnded : DeviceState::kStreaming;
  }
  DeviceStatistics Statistics() const override { return statistics_; }

 private:
  DeviceUri uri_;
  SimulatedCamera camera_;
  bool started_ = false;
  std::uint64_t next_ = 0;
  DeviceStatistics statistics_;
};

}  // namespace

std::unique_ptr<Device> OpenSimulatedDevice(const DeviceUri& uri) {
  if (uri.path == "board" || uri.path == "card") return OpenSimulatedBoard(uri);
  return std::make_unique<SimulatedDevice>(uri);
}

}  // namespace ulf
