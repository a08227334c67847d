#include "acquisition/device/replay_device.h"

#include <fmt/format.h>
#include <algorithm>
#include <atomic>
#include <exception>
#include <thread>

#include "acquisition/device/frame_queue.h"
#include "acquisition/device/replay_source.h"
#include "core/base/error.h"
#include "core/base/host_time.h"
#include "core/base/mutex.h"
#include "core/base/stop_signal.h"

namespace ulf::acquisition {
namespace {

class ReplayDevice : public Device {
 public:
  ReplayDevice(std::string uri, std::unique_ptr<ReplaySource> source)
      : uri_(std::move(uri)), source_(std::move(source)), header_(source_->Header()) {
    const auto shared = [](const std::optional<FlatField>& known) {
      return known ? std::make_shared<const FlatField>(*known) : nullptr;
    };
    flat_field_ = shared(header_.flat_field);
    still_flat_field_ = shared(header_.still_flat_field);
  }

  // The camera's; where it is unknown, the model is a description of the files.
  DeviceInfo Info() const override {
    DeviceInfo info = header_.device;
    info.uri = uri_;
    if (info.model.empty() && info.serial.empty()) info.model = source_->Describe();
    return info;
  }
  std::optional<CameraModel> Camera() const override { return header_.camera; }
  std::optional<CameraModel> StillCamera() const override { return header_.still_camera; }
  std::shared_ptr<const FlatField> KnownFlatField(FrameKind kind) const override {
    return kind == FrameKind::kStill ? still_flat_field_ : flat_field_;
  }
  std::shared_ptr<const ColorProfile> KnownColorProfile(FrameKind kind) const override {
    const auto& known = kind == FrameKind::kStill ? header_.still_color_profile : header_.color_profile;
    return known ? std::make_shared<const ColorProfile>(*known) : nullptr;
  }
  std::optional<SensorWindow> Window() const override { return header_.window; }
  bool IsLive() const override { return false; }
  FrameSource Source() const override { return source_->Source(); }
  bool HasLiveFrames() const override { return source_->HasLiveFrames(); }
  bool TakesStills() const override { return header_.takes_stills; }
  // As a camera, it is busy until the requested photograph has come.
  StillRequest RequestStill() override {
    if (!running_ || asked_ || !source_->HasRequestedPhotographs()) return StillRequest::kBusy;
    asked_ = true;
    return StillRequest::kAsked;
  }
  std::optional<double> ShareDone() const override {
    const double length = source_->Length();
    if (length <= 0) return std::nullopt;
    return std::min(1.0, static_cast<double>(statistics_.delivered + statistics_.incomplete) / length);
  }

  void Start() override {
    source_->Rewind();
    running_ = true;
    asked_ = false;
    state_ = DeviceState::kStreaming;
    statistics_ = {};
  }

  std::optional<Frame> Next(std::chrono::milliseconds /*timeout*/) override {
    if (!running_) return std::nullopt;
    std::optional<Frame> frame = source_->Next();
    if (frame) {
      ++(frame->status == FrameStatus::kComplete ? statistics_.delivered : statistics_.incomplete);
      statistics_.bytes += frame->image.pixels.total() * frame->image.pixels.elemSize();
      if (frame->requested_s) asked_ = false;
    } else {
      state_ = DeviceState::kEnded;
    }
    running_ = frame.has_value();
    return frame;
  }

  void Stop() override {
    running_ = false;
    state_ = DeviceState::kEnded;
  }
  DeviceState State() const override { return state_; }
  DeviceStatistics Statistics() const override { return statistics_; }

 private:
  std::string uri_;
  std::unique_ptr<ReplaySource> source_;
  const RecordingHeader header_;
  std::shared_ptr<const FlatField> flat_field_, still_flat_field_;
  bool running_ = false, asked_ = false;
  DeviceState state_ = DeviceState::kConnected;
  DeviceStatistics statistics_;
};

ReplayOptions OptionsOf(const DeviceUri& uri) {
  uri.AllowOnly({"fps", "glob", "transfer", "speed"});
  ReplayOptions options{.uri = uri.Text(),
                        .path = uri.path,
                        .fps = uri.Number("fps"),
                        .glob = uri.Option("glob"),
                        .transfer = {},
                        .speed = uri.Number("speed").value_or(0)};
  if (options.speed < 0)
    throw Refused(options.uri, "speed must be 0 (as fast as frames are read) or a factor (1: as recorded)");
  if (uri.path.empty())
    throw Refusal("", "", "'replay:' needs a path: replay:FOLDER, replay:VIDEO or replay:LIGHT_FIELD", "");
  if (options.fps && *options.fps <= 0) throw Refused(options.uri, "fps must be positive");
  if (const auto transfer = uri.Option("transfer")) {
    if (*transfer != "linear" && *transfer != "srgb")
      throw Refused(options.uri, "transfer must be 'linear' or 'srgb'");
    options.transfer = *transfer == "linear" ? Transfer::kLinear : Transfer::kSrgb;
  }
  return options;
}

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
    queue_ = std::make_unique<FrameQueue>(kWaitingFrames);
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
    return over_ && !failure_ && queue_->Size() == 0 ? DeviceState::kEnded : DeviceState::kStreaming;
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
        const auto due = began + DurationOf((frame->device_time_s - *first_s) / speed_);
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
  std::unique_ptr<FrameQueue> queue_;
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

std::string WithReplaySpeed(const std::string& text, const std::optional<double>& speed) {
  if (!speed) return text;
  DeviceUri uri = DeviceUri::Parse(text);
  if (uri.scheme != "replay")
    throw Refusal(Parameter("speed"), fmt::format("{:g}", *speed),
                  fmt::format("'{}' is not a recording", text),
                  fmt::format("leave {} out for a camera", Parameter("speed")));
  uri.Set("speed", fmt::format("{:g}", *speed));
  return uri.Text();
}

std::unique_ptr<Device> OpenReplayDevice(const DeviceUri& uri) {
  const ReplayOptions options = OptionsOf(uri);
  auto replay = std::make_unique<ReplayDevice>(options.uri, OpenReplaySource(options));
  if (options.speed > 0) return MakePacedDevice(std::move(replay), options.speed);
  return replay;
}

std::unique_ptr<Device> MakePacedDevice(std::unique_ptr<Device> recording, double speed) {
  return std::make_unique<PacedDevice>(std::move(recording), speed);
}

}  // namespace ulf::acquisition
