#include "acquisition/simulator/bench_device.h"

#include <string>
#include <utility>

#include "core/base/host_time.h"

namespace ulf::acquisition {
namespace {

class BenchDevice : public Device {
 public:
  explicit BenchDevice(Bench bench) : bench_(std::move(bench)) {}

  DeviceInfo Info() const override {
    return {.uri = bench_.uri.Text(),
            .maker = "ULF",
            .model = "simulated camera",
            .serial = "sim-bench-" + std::to_string(bench_.seed),
            .bus = "simulated",
            .problem = {}};
  }
  std::optional<CameraModel> Camera() const override { return bench_.camera; }
  bool IsLive() const override { return false; }
  HeldAutomatics Held() const override { return bench_.held; }
  std::optional<SensorWindow> Window() const override { return bench_.window; }
  void Start() override { started_ = true; }
  void Stop() override { started_ = false; }
  std::optional<Frame> Next(std::chrono::milliseconds /*timeout*/) override {
    if (State() != DeviceState::kStreaming) return std::nullopt;
    Frame frame;
    frame.device_time_s = static_cast<double>(next_) / bench_.fps;
    frame.image = bench_.picture(next_, frame.device_time_s);
    frame.id = next_++;
    frame.host_time_s = EpochSeconds();
    ++statistics_.delivered;
    return frame;
  }
  DeviceState State() const override {
    if (!started_) return DeviceState::kConnected;
    return bench_.is_over(next_) ? DeviceState::kEnded : DeviceState::kStreaming;
  }
  DeviceStatistics Statistics() const override { return statistics_; }

 private:
  const Bench bench_;
  bool started_ = false;
  std::uint64_t next_ = 0;
  DeviceStatistics statistics_;
};

}  // namespace

std::unique_ptr<Device> MakeBenchDevice(Bench bench) {
  return std::make_unique<BenchDevice>(std::move(bench));
}

}  // namespace ulf::acquisition
