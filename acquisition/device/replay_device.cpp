#include "acquisition/device/replay_device.h"

#include <fmt/format.h>

#include <algorithm>

#include "acquisition/device/paced_device.h"
#include "acquisition/device/replay_source.h"
#include "core/base/error.h"

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
  DeviceState state_ = DeviceState::kStreaming;
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
    throw Refusal(options.uri, "",
                  "speed must be 0 (as fast as frames are read) or a factor (1: as recorded)", "");
  if (uri.path.empty())
    throw Refusal("replay:", "", "'replay:' needs a path: replay:FOLDER, replay:VIDEO or replay:LIGHT_FIELD");
  if (options.fps && *options.fps <= 0) throw Refusal(options.uri, "", "fps must be positive", "");
  if (const auto transfer = uri.Option("transfer")) {
    if (*transfer != "linear" && *transfer != "srgb")
      throw Refusal(options.uri, "", "transfer must be 'linear' or 'srgb'", "");
    options.transfer = *transfer == "linear" ? Transfer::kLinear : Transfer::kSrgb;
  }
  return options;
}

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

}  // namespace ulf::acquisition
