#include "acquisition/v4l2/v4l2_device.h"

#include <poll.h>
#include <spdlog/spdlog.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "acquisition/device/live_driver.h"
#include "acquisition/v4l2/v4l2_controls.h"
#include "acquisition/v4l2/v4l2_modes.h"
#include "acquisition/v4l2/v4l2_node.h"
#include "acquisition/v4l2/v4l2_stream.h"
#include "core/base/error.h"
#include "core/base/file_descriptor.h"
#include "core/base/host_time.h"

namespace ulf::acquisition {
namespace {

using std::chrono::milliseconds;
using Clock = std::chrono::steady_clock;

// Returns how long the capture thread waits for a frame before it does its other work, and its pause where no
// buffer is filled yet. Guessed.
constexpr milliseconds kFrameWait(100), kEmptyPause(2);
// How long a camera may send nothing until it counts as stalled, and as lost: the longer of seconds and frame
// periods. Guessed.
constexpr double kStalledS = 0.5, kStalledPeriods = 3, kLostS = 5.5, kLostPeriods = 10;

struct V4l2Options {
  V4l2ModeRequest request;
  V4l2Io io = V4l2Io::kMmap;
  double settle_s = 1;    // the automatics run so long; guessed: webcams adapt within a second
  std::size_t queue = 4;  // frames that may wait for the reader
  std::vector<std::pair<std::string, std::string>> controls;  // in the URI's order
};

// Throws Refusal that names the invalid option. Names of controls are checked when the camera is open.
V4l2Options V4l2OptionsOf(const DeviceUri& uri) {
  V4l2Options options;
  std::set<std::string> given;
  for (const auto& [key, value] : uri.options) {
    if (!given.insert(key).second) throw Refused(uri, fmt::format("{} is given twice", key));
    if (key == "format") {
      options.request.fourcc = FourccByName(value);
      if (!options.request.fourcc)
        throw Refused(uri, fmt::format("ulf does not read the pixel format {} from webcams", value),
                      "use YUYV, NV12 or MJPEG");
    } else if (key == "size") {
      int width = 0, height = 0;
      char rest = 0;
      if (std::sscanf(value.c_str(), "%dx%d%c", &width, &height, &rest) != 2 || width < 1 || height < 1)
        throw Refused(uri, "size must read WIDTHxHEIGHT, such as 1280x720");
      options.request.size = {width, height};
    } else if (key == "fps") {
      options.request.fps = uri.Number(key);
      if (*options.request.fps <= 0) throw Refused(uri, "fps must be above 0");
    } else if (key == "io") {
      if (value != "mmap" && value != "userptr")
        throw Refused(uri, fmt::format("io must be mmap or userptr, not '{}'", value));
      options.io = value == "mmap" ? V4l2Io::kMmap : V4l2Io::kUserPtr;
    } else if (key == "settle") {
      options.settle_s = uri.Number(key, options.settle_s, 0, 60);
    } else if (key == "queue") {
      options.queue = static_cast<std::size_t>(*uri.Whole(key, 1, 1000));
    } else {
      options.controls.emplace_back(key, value);
    }
  }
  return options;
}

class V4l2Device : public LiveDriver {
 public:
  explicit V4l2Device(const DeviceUri& uri) : options_(V4l2OptionsOf(uri)) {
    const V4l2Camera camera = ResolveV4l2Camera(uri.Text(), uri.path);
    DeviceUri named = uri;
    if (uri.path.empty()) named.path = camera.node;
    uri_ = named.Text();
    info_ = camera.info;
    info_.uri = uri_;
    node_ = std::make_unique<V4l2Node>(camera.node);
    const V4l2Mode mode = ChooseV4l2Mode(uri_, V4l2Modes(*node_, options_.request.size), options_.request);
    configured_ = SetV4l2Mode(*node_, mode, options_.request.fps);
    controls_ = V4l2Controls(*node_);
    CheckControls();
    if (!stop_.IsOpen())
      throw Error("{}: the system has no file descriptors left; close other programs", uri_);
    spdlog::debug("{}: {} {} {} {}x{}, period {:.4f} s", uri_, info_.maker, info_.model,
                  configured_.format.name, configured_.width, configured_.height, configured_.period_s);
  }

  ~V4l2Device() override { Stop(); }

  HeldAutomatics Held() const override {
    const MutexLock lock(mutex_);
    return held_;
  }

  void Start() override {
    if (thread_.joinable()) return;
    if (state_ == DeviceState::kLost) throw Error("{}: {}; open the device again", uri_, Info().problem);
    stream_ = std::make_unique<V4l2Stream>(*node_, options_.io, configured_.image_bytes);
    {
      const MutexLock lock(mutex_);
      queue_ = std::make_unique<FrameQueue>(options_.queue);
    }
    statistics_.Begin();
    state_ = DeviceState::kStreaming;
    thread_ = ReadingThread([this] { Capture(); },
                            [this](const std::string& why) { Lose("reading its frames failed: " + why); });
  }

  void Stop() override {
    if (!thread_.joinable()) return;
    const std::uint64_t one = 1;
    if (write(stop_.Number(), &one, sizeof one) < 0)
      spdlog::error("{}: the stop signal cannot be sent", uri_);
    thread_.join();
    std::uint64_t taken = 0;
    if (read(stop_.Number(), &taken, sizeof taken) < 0) spdlog::debug("{}: no stop signal was sent", uri_);
    queue_->Close();
    stream_.reset();
    statistics_.End();
    if (state_ == DeviceState::kLost)
      node_.reset();
    else
      state_ = DeviceState::kEnded;
  }

  DeviceStatistics Statistics() const override {
    DeviceStatistics statistics = statistics_.Now();
    {
      const MutexLock lock(mutex_);
      if (queue_) statistics.dropped = queue_->Dropped();
    }
    statistics.transport.emplace_back(TransportFigure::kWhileSettling, statistics_.WhileSettlingCount());
    return statistics;
  }

 private:
  // Throws Refusal for an invalid name or value of the URI's controls, before anything is written.
  void CheckControls() const {
    for (const auto& [name, value] : options_.controls) {
      const auto control = FindControl(name);
      if (control == controls_.end()) {
        std::string list = "format, size, fps, io, settle, queue, reconnect_s";
        for (const V4l2Control& known : controls_)
          list += ", " + (known.short_name.empty() ? known.name : known.short_name);
        throw Refusal("", name, fmt::format("'{}' has no option or control '{}'", uri_, name),
                      fmt::format("known are: {}", list));
      }
      if (control->flags & V4L2_CTRL_FLAG_READ_ONLY)
        throw Refused(fmt::format("'{}'", uri_), fmt::format("the control {} is read-only", name));
      V4l2ControlValue(uri_, *control, value);
    }
  }

  std::vector<V4l2Control>::const_iterator FindControl(const std::string& name) const {
    return std::find_if(controls_.begin(), controls_.end(),
                        [&](const V4l2Control& control) { return control.Answers(name); });
  }

  // Switches the automatics off, writes the URI's controls and reads them back.
  void FreezeAndSet() {
    std::vector<std::string> asked;
    for (const auto& [name, value] : options_.controls) asked.push_back(name);
    const V4l2Frozen frozen = FreezeV4l2Automatics(*node_, controls_, asked);
    for (const std::string& words : frozen.held) events_.Notice(words);
    for (const std::string& words : frozen.refused) events_.Notice(words);
    for (const auto& [name, text] : options_.controls) {
      const V4l2Control& control = *FindControl(name);
      const int value = V4l2ControlValue(uri_, control, text);
      const int error = SetV4l2Control(*node_, control.id, value);
      const auto got = GetV4l2Control(*node_, control.id);
      if (error != 0 || (got && *got != value))
        events_.Notice(fmt::format("the camera changed {}={} to {}{}", name, text,
                                   got ? V4l2ControlText(control, *got) : "an unknown value",
                                   error ? fmt::format(" ({})", std::strerror(error)) : ""));
    }
    exposure_s_ = V4l2ExposureSeconds(*node_, controls_);
    {
      const MutexLock lock(mutex_);
      held_ = HeldV4l2Automatics(*node_, controls_);
    }
    AddToUri(frozen.values);
  }

  // Adds the held values to the URI, so that a camera opened again by it takes the same pictures.
  void AddToUri(const std::vector<std::pair<std::string, int>>& values) {
    if (values.empty()) return;
    const MutexLock lock(mutex_);
    DeviceUri uri = DeviceUri::Parse(info_.uri);
    std::erase_if(uri.options, [](const auto& option) { return option.first == "settle"; });
    uri.options.emplace_back("settle", "0");
    for (const auto& [name, value] : values)
      if (std::none_of(
              options_.controls.begin(), options_.controls.end(),
              [&, &name = name](const auto& asked) { return FindControl(asked.first)->Answers(name); }))
        uri.options.emplace_back(name, std::to_string(value));
    info_.uri = uri.Text();
  }

  // The capture thread: moves frames from the driver's buffers to the queue until Stop() or the camera is
  // lost.
  void Capture() {
    const double stall_s = std::max(kStalledS, kStalledPeriods * configured_.period_s);
    const double lost_s = std::max(kLostS, kLostPeriods * configured_.period_s);
    const auto begun = Clock::now();
    StallReport stall(events_);
    bool settled = options_.settle_s == 0;
    if (settled) FreezeAndSet();
    while (!WaitForFrame(kFrameWait)) {
      if (!settled && SecondsSince(begun) >= options_.settle_s) {
        settled = true;
        FreezeAndSet();
        // The buffers still contain frames that were exposed before.
        settled_at_ = Clock::now();
      }
      std::optional<V4l2Stream::Filled> filled;
      const int error = stream_->Dequeue(filled);
      if (filled) {
        settled ? Take(*filled) : CountSettling(*filled);
        if (const int refused = stream_->Requeue(*filled); refused != 0)
          return Lose(V4l2Problem(node_->Path(), refused));
        stall.FrameCame();
        continue;
      }
      if (error != EAGAIN) return Lose(V4l2Problem(node_->Path(), error));
      // Some drivers wake their readers before a buffer is filled.
      if (Pause(kEmptyPause)) return;
      const double silence_s = SecondsSince(stall.LastFrame());
      stall.NoFrame(silence_s, stall_s);
      if (silence_s > lost_s)
        return Lose(
            fmt::format("no frame for {:.1f} s although the camera is connected; unplug it and plug it in "
                        "again, or use another USB socket",
                        silence_s));
    }
  }

  // Returns true when the thread is to stop; else a frame may have arrived, or the time is over.
  bool WaitForFrame(milliseconds timeout) const {
    std::array<pollfd, 2> waiting{{{stop_.Number(), POLLIN, 0}, {node_->Number(), POLLIN, 0}}};
    poll(waiting.data(), waiting.size(), static_cast<int>(timeout.count()));
    return waiting[0].revents != 0;
  }
  bool Pause(milliseconds time) const {
    pollfd waiting{stop_.Number(), POLLIN, 0};
    return poll(&waiting, 1, static_cast<int>(time.count())) > 0;
  }

  void Lose(const std::string& problem) {
    DescribeLoss(problem);
    statistics_.End();
    state_ = DeviceState::kLost;
    queue_->Close();
  }

  // Discards a frame; gaps between discarded frames count as missing too.
  void CountSettling(const V4l2Stream::Filled& filled) {
    statistics_.Arrived(filled.header.sequence);
    statistics_.WhileSettling();
  }

  void Take(const V4l2Stream::Filled& filled) {
    const v4l2_buffer& header = filled.header;
    const double stamp_s =
        static_cast<double>(header.timestamp.tv_sec) + 1e-6 * static_cast<double>(header.timestamp.tv_usec);
    const bool monotonic = (header.flags & V4L2_BUF_FLAG_TIMESTAMP_MASK) == V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC;
    // Discards frames that were exposed, at least in part, while the automatics were on.
    if (monotonic && settled_at_ != Clock::time_point() &&
        stamp_s <
            std::chrono::duration<double>(settled_at_.time_since_epoch()).count() + configured_.period_s)
      return CountSettling(filled);
    Frame frame;
    frame.id = header.sequence;
    frame.host_time_s = EpochSeconds();
    frame.exposure_s = exposure_s_;
    frame.device_time_s = stamp_s;
    if (!monotonic || stamp_s == 0) {
      frame.device_time_s = frame.host_time_s;  // a driver without a clock
    } else {
      const bool stamped_at_start =
          (header.flags & V4L2_BUF_FLAG_TSTAMP_SRC_MASK) == V4L2_BUF_FLAG_TSTAMP_SRC_SOE;
      frame.device_time_s += (stamped_at_start ? 0.5 : -0.5) * frame.exposure_s;
    }
    if (header.flags & V4L2_BUF_FLAG_ERROR || !Fill(filled.bytes, frame))
      frame.status = FrameStatus::kIncomplete;
    statistics_.Arrived(frame.id);
    if (frame.status == FrameStatus::kIncomplete) statistics_.Incomplete();
    if (monotonic) statistics_.Timed(stamp_s, frame.host_time_s, 0);
    queue_->Push(std::move(frame));
  }

  // Returns false when the buffer does not contain the configured picture.
  bool Fill(std::span<const std::uint8_t> bytes, Frame& frame) {
    try {
      if (configured_.format.packing == PixelPacking::kJpeg) {
        auto jpeg = StandaloneJpeg(bytes);
        if (!jpeg) return false;
        frame.encoded = {".jpg", std::make_shared<const std::string>(std::move(*jpeg))};
        bytes = {reinterpret_cast<const std::uint8_t*>(frame.encoded->bytes->data()),
                 frame.encoded->bytes->size()};
      }
      frame.image = ImageFromBytes(configured_.format, configured_.width, configured_.height, bytes.data(),
                                   bytes.size(), configured_.layout);
      frame.image.transfer = configured_.transfer;
      return true;
    } catch (const Error& error) {
      if (!std::exchange(said_incomplete_, true))
        events_.Notice(fmt::format("a frame is incomplete: {}", error.what()));
      frame.encoded.reset();
      return false;
    }
  }

  const V4l2Options options_;
  std::string uri_;  // as it was opened
  std::unique_ptr<V4l2Node> node_;
  V4l2Configured configured_;
  std::vector<V4l2Control> controls_;
  std::unique_ptr<V4l2Stream> stream_;
  const FileDescriptor stop_{eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)};
  // Used by the capture thread.
  double exposure_s_ = 0;
  Clock::time_point settled_at_;
  bool said_incomplete_ = false;

  HeldAutomatics held_ ULF_GUARDED_BY(mutex_);
};

}  // namespace

std::unique_ptr<Device> OpenV4l2Device(const DeviceUri& uri) { return std::make_unique<V4l2Device>(uri); }

std::vector<DeviceInfo> ListV4l2Devices() {
  std::vector<DeviceInfo> list;
  for (const V4l2Camera& camera : FindV4l2Cameras()) list.push_back(camera.info);
  return list;
}

}  // namespace ulf::acquisition
