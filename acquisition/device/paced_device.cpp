#include "acquisition/device/paced_device.h"

#include <atomic>
#include <exception>
#include <thread>

#include "acquisition/device/photograph_inbox.h"
#include "core/base/host_time.h"
#include "core/base/mutex.h"
#include "core/base/stop_signal.h"

namespace ulf::acquisition {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

constexpr std::size_t kWaitingFrames = 4;  // as the default `queue` of the cameras

class PacedDevice : public Device {
 public:
  PacedDevice(std::unique_ptr<Device> recording, double speed)
      : recording_(std::move(recording)), speed_(speed) {}
  ~PacedDevice() override { Stop(); }

  DeviceInfo Info() const override { return recording_->Info(); }
  std::optional<CameraModel> Camera() const override { return recording_->Camera(); }
  std::optional<CameraModel> StillCamera() const override { return recording_->StillCamera(); }
  std::shared_ptr<const FlatField> KnownFlatField(FrameKind kind) const override {
    return recording_->KnownFlatField(kind);
  }
  std::shared_ptr<const ColorProfile> KnownColorProfile(FrameKind kind) const override {
    return recording_->KnownColorProfile(kind);
  }
  std::optional<SensorWindow> Window() const override { return recording_->Window(); }
  bool TakesStills() const override { return recording_->TakesStills(); }
  StillRequest RequestStill() override {
    const MutexLock lock(recording_mutex_);
    return recording_->RequestStill();
  }
  bool IsLive() const override { return true; }
  FrameSource Source() const override { return recording_->Source(); }
  bool HasLiveFrames() const override { return recording_->HasLiveFrames(); }
  std::optional<double> ShareDone() const override { return share_done_.load(); }

  void Start() override {
    if (thread_.joinable()) return;
    recording_->Start();
    queue_ = std::make_unique<PhotographInbox>(kWaitingFrames);
    delivered_ = bytes_ = 0;
    {
      const MutexLock lock(mutex_);
      stop_ = false;
    }
    over_ = false;
    failure_ = nullptr;
    started_ = true;
    thread_ = std::thread([this] { Play(); });
  }

  void Stop() override {
    {
      const MutexLock lock(mutex_);
      stop_ = true;
    }
    wake_.notify_all();
    if (thread_.joinable()) thread_.join();
    if (queue_) queue_->Close();
    if (started_) recording_->Stop();
    started_ = false;
  }

  std::optional<Frame> Next(milliseconds timeout) override {
    // After Stop() the reader can still take the photographs that have arrived, as from the camera.
    if (!queue_ || (!started_ && !recording_->TakesStills())) return std::nullopt;
    auto frame = queue_->Pop(timeout);
    if (frame) {
      ++delivered_;
      bytes_ += frame->image.pixels.total() * frame->image.pixels.elemSize();
      return frame;
    }
    if (over_ && failure_) std::rethrow_exception(failure_);
    return std::nullopt;
  }

  DeviceState State() const override {
    if (!started_) return DeviceState::kConnected;
    // After a failure the state must not say that the recording ended: Next() throws the failure.
    return over_ && !failure_ && queue_->IsEmpty() ? DeviceState::kEnded : DeviceState::kStreaming;
  }

  DeviceStatistics Statistics() const override {
    const MutexLock lock(recording_mutex_);
    DeviceStatistics statistics = recording_->Statistics();
    // The recording counts frames that it played; the reader may not have taken them yet.
    statistics.delivered = delivered_;
    statistics.bytes = bytes_;
    if (queue_) statistics.dropped += queue_->Dropped();
    return statistics;
  }

 private:
  void Play() {
    InstallSignalStack();
    try {
      std::optional<double> first_s;
      Clock::time_point began;
      while (auto frame = NextRecorded()) {
        if (!first_s) {
          first_s = frame->device_time_s;
          began = Clock::now();
        }
        const auto due = began + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(
                                     (frame->device_time_s - *first_s) / speed_));
        {
          MutexLock lock(mutex_);
          if (wake_.wait_until(lock, due, [this]() ULF_REQUIRES(mutex_) { return stop_; })) break;
        }
        frame->host_time_s = EpochSeconds();
        queue_->Push(std::move(*frame));
      }
    } catch (...) {
      failure_ = std::current_exception();
    }
    over_ = true;
    queue_->Close();
  }

  std::optional<Frame> NextRecorded() {
    const MutexLock lock(recording_mutex_);
    auto frame = recording_->Next(milliseconds(0));
    share_done_ = recording_->ShareDone().value_or(0);
    return frame;
  }

  // Guards the recording's frames, statistics and requests; the rest of it does not change while it plays.
  mutable Mutex recording_mutex_;
  const std::unique_ptr<Device> recording_;
  const double speed_;
  std::unique_ptr<PhotographInbox> queue_;
  std::atomic<std::uint64_t> delivered_{0}, bytes_{0};
  std::atomic<double> share_done_{0};
  std::atomic<bool> over_{false};
  std::exception_ptr failure_;  // set before over_
  bool started_ = false;
  Mutex mutex_;
  ConditionVariable wake_;
  bool stop_ ULF_GUARDED_BY(mutex_) = false;
  std::thread thread_;
};

}  // namespace

std::unique_ptr<Device> MakePacedDevice(std::unique_ptr<Device> recording, double speed) {
  return std::make_unique<PacedDevice>(std::move(recording), speed);
}

}  // namespace ulf::acquisition
