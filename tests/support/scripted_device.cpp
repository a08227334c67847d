#include "tests/support/scripted_device.h"

#include <atomic>
#include <thread>

#include "acquisition/device/frame_queue.h"
#include "core/base/error.h"
#include "tests/support/floors.h"

namespace ulf::test {

using std::chrono::milliseconds;

// 50 frames a second into a queue of eight, from the camera's own clock.
class ScriptedDriver : public Device {
 public:
  explicit ScriptedDriver(std::shared_ptr<ScriptedCamera> camera) : camera_(std::move(camera)) {
    const std::lock_guard lock(camera_->mutex_);
    info_ = {.uri = "scripted:",
             .maker = camera_->maker_,
             .model = camera_->model_,
             .serial = camera_->serial_,
             .bus = "test",
             .problem = ""};
    size_ = camera_->size_;
    ++camera_->open_;
  }
  ~ScriptedDriver() override {
    Stop();
    milliseconds wait{0};
    {
      const std::lock_guard lock(camera_->mutex_);
      if (lost_) wait = camera_->closing_;
    }
    std::this_thread::sleep_for(wait);
    const std::lock_guard lock(camera_->mutex_);
    --camera_->open_;
  }

  DeviceInfo Info() const override {
    DeviceInfo info = info_;
    if (lost_) info.problem = "the scripted cable is out";
    return info;
  }
  bool IsLive() const override { return true; }
  void Start() override {
    if (thread_.joinable()) return;
    stop_ = false;
    thread_ = std::thread([this] { Run(); });
  }
  void Stop() override {
    stop_ = true;
    if (thread_.joinable()) thread_.join();
  }
  std::optional<Frame> Next(milliseconds timeout) override {
    auto frame = queue_.Pop(timeout);
    if (frame) {
      ++delivered_;
    }
    return frame;
  }
  DeviceState State() const override {
    return lost_ && queue_.Size() == 0 ? DeviceState::kLost : DeviceState::kStreaming;
  }
  DeviceStatistics Statistics() const override {
    DeviceStatistics statistics;
    statistics.delivered = delivered_;
    statistics.dropped = queue_.Dropped();
    statistics.transport = {
        {acquisition::TransportFigure::kPacketsReceived, 10.0 * static_cast<double>(delivered_)},
        {acquisition::TransportFigure::kPacketSize, 1400},
        {acquisition::TransportFigure::kPayloadBytes, 307'200},
        {acquisition::TransportFigure::kSetFps, 15},
        {acquisition::TransportFigure::kExposureUs, 4000},
        {acquisition::TransportFigure::kBytesReceived, 1e5 * static_cast<double>(delivered_)},
        {acquisition::TransportFigure::kWhileSettling, 1},
        {acquisition::TransportFigure::kClockShared, 1}};
    return statistics;
  }

 private:
  void Run() {
    while (!stop_) {
      std::this_thread::sleep_for(milliseconds(20));
      Frame frame;
      std::optional<milliseconds> noticed_after;
      {
        const std::lock_guard lock(camera_->mutex_);
        if (!camera_->Answers()) noticed_after = camera_->noticing_;
      }
      if (noticed_after) {
        std::this_thread::sleep_for(*noticed_after);
        lost_ = true;
        return;
      }
      {
        const std::lock_guard lock(camera_->mutex_);
        frame.image.pixels = cv::Mat(size_, CV_8UC1, cv::Scalar(90));
        frame.id = camera_->next_id_++;
        frame.device_time_s =
            std::chrono::duration<double>(ScriptedCamera::Clock::now() - camera_->clock_zero_).count();
      }
      frame.host_time_s =
          std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
      queue_.Push(std::move(frame));
    }
  }

  std::shared_ptr<ScriptedCamera> camera_;
  DeviceInfo info_;
  cv::Size size_;
  FrameQueue queue_{8};
  std::atomic<bool> lost_{false}, stop_{false};
  std::atomic<std::uint64_t> delivered_{0};
  std::thread thread_;
};

void ScriptedCamera::Unplug() {
  const std::lock_guard lock(mutex_);
  plugged_ = false;
}

void ScriptedCamera::PlugIn(milliseconds boot, bool switched_off) {
  const std::lock_guard lock(mutex_);
  plugged_ = true;
  answers_from_ = Clock::now() + boot;
  if (!switched_off) return;
  clock_zero_ = answers_from_;
  next_id_ = 1;
}

void ScriptedCamera::SetMakerAndModel(const std::string& maker, const std::string& model) {
  const std::lock_guard lock(mutex_);
  maker_ = maker, model_ = model;
}

void ScriptedCamera::SetSerial(const std::string& serial) {
  const std::lock_guard lock(mutex_);
  serial_ = serial;
}

void ScriptedCamera::SetSize(cv::Size size) {
  const std::lock_guard lock(mutex_);
  size_ = size;
}

void ScriptedCamera::SetNoticingTakes(milliseconds time) {
  const std::lock_guard lock(mutex_);
  noticing_ = time;
}

void ScriptedCamera::SetOpeningTakes(milliseconds time) {
  const std::lock_guard lock(mutex_);
  opening_ = time;
}

void ScriptedCamera::SetClosingTakes(milliseconds time) {
  const std::lock_guard lock(mutex_);
  closing_ = time;
}

int ScriptedCamera::Openings() const {
  const std::lock_guard lock(mutex_);
  return openings_;
}

int ScriptedCamera::Open() const {
  const std::lock_guard lock(mutex_);
  return open_;
}

bool ScriptedCamera::Answers() const { return plugged_ && Clock::now() >= answers_from_; }

std::unique_ptr<Device> ScriptedCamera::OpenDriver() {
  milliseconds wait;
  {
    const std::lock_guard lock(mutex_);
    ++openings_;
    wait = opening_;
  }
  std::this_thread::sleep_for(wait);
  {
    const std::lock_guard lock(mutex_);
    if (!Answers()) throw Error("scripted: no answer; check the cable");
  }
  return std::make_unique<ScriptedDriver>(shared_from_this());
}

}  // namespace ulf::test
