#include "acquisition/v4l2/v4l2_device.h"

#include <poll.h>
#include <spdlog/spdlog.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cmath>
#include <thread>

#include "acquisition/device/frame_id_counter.h"
#include "acquisition/device/frame_queue.h"
#include "acquisition/v4l2/motion_jpeg.h"
#include "acquisition/v4l2/v4l2_controls.h"
#include "acquisition/v4l2/v4l2_modes.h"
#include "acquisition/v4l2/v4l2_node.h"
#include "acquisition/v4l2/v4l2_options.h"
#include "acquisition/v4l2/v4l2_stream.h"
#include "core/base/clock_offset.h"
#include "core/base/error.h"
#include "core/base/host_time.h"
#include "core/base/mutex.h"
#include "core/base/stop_signal.h"

namespace ulf::acquisition {
namespace {

using std::chrono::milliseconds;
using Clock = std::chrono::steady_clock;

// How long the capture thread waits for a frame before it does its other work, and its pause where no buffer
// is filled yet. Guessed.
constexpr milliseconds kFrameWait(100), kEmptyPause(2);

class V4l2Device : public Device {
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
    stop_ = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    if (stop_ < 0) throw Error("{}: the system has no file descriptors left; close other programs", uri_);
    spdlog::debug("{}: {} {} {} {}x{}, period {:.4f} s", uri_, info_.maker, info_.model,
                  configured_.format.name, configured_.width, configured_.height, configured_.period_s);
  }

  ~V4l2Device() override {
    Stop();
    close(stop_);
  }

  DeviceInfo Info() const override {
    const MutexLock lock(mutex_);
    return info_;
  }
  bool IsLive() const override { return true; }
  FrameSource Source() const override { return FrameSource::kSettableCamera; }
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
      statistics_ = {};
      ids_ = {};
      while_settling_ = 0;
      clock_ = {};
      started_ = Clock::now();
    }
    state_ = DeviceState::kStreaming;
    thread_ = std::thread([this] {
      InstallSignalStack();
      try {
        Capture();
      } catch (const std::exception& error) {
        Lose(fmt::format("reading its frames failed: {}", error.what()));
      }
    });
  }

  std::optional<Frame> Next(milliseconds timeout) override {
    if (!queue_) return std::nullopt;
    std::optional<Frame> frame = queue_->Pop(timeout);
    if (frame && frame->status == FrameStatus::kComplete) {
      const MutexLock lock(mutex_);
      ++statistics_.delivered;
      statistics_.bytes += frame->image.pixels.total() * frame->image.pixels.elemSize();
    }
    return frame;
  }

  void Stop() override {
    if (!thread_.joinable()) return;
    const std::uint64_t one = 1;
    if (write(stop_, &one, sizeof one) < 0) spdlog::error("{}: the stop signal cannot be sent", uri_);
    thread_.join();
    std::uint64_t taken = 0;
    if (read(stop_, &taken, sizeof taken) < 0) spdlog::debug("{}: no stop signal was sent", uri_);
    queue_->Close();
    stream_.reset();
    const MutexLock lock(mutex_);
    statistics_.seconds = SecondsSince(started_);
    if (state_ == DeviceState::kLost)
      node_.reset();
    else
      state_ = DeviceState::kEnded;
  }

  DeviceState State() const override { return state_; }

  DeviceStatistics Statistics() const override {
    const MutexLock lock(mutex_);
    DeviceStatistics statistics = statistics_;
    statistics.missing = ids_.Missing();
    if (queue_) statistics.dropped = queue_->Dropped();
    if (state_ == DeviceState::kStreaming) statistics.seconds = SecondsSince(started_);
    statistics.out_of_order = ids_.OutOfOrder();
    statistics.clock_offset_s = clock_.OffsetS();
    statistics.clock_jitter_s = clock_.JitterS();
    statistics.transport.emplace_back("frames while settling", static_cast<double>(while_settling_));
    return statistics;
  }

  std::vector<DeviceEvent> TakeEvents() override {
    const MutexLock lock(mutex_);
    return std::exchange(events_, {});
  }

 private:
  void Say(DeviceEventKind kind, const std::string& text, double silence_s = 0) {
    const MutexLock lock(mutex_);
    events_.push_back({kind, EpochSeconds(), text, silence_s});
  }

  // Throws UsageError for an invalid name or value of the URI's controls, before anything is written.
  void CheckControls() const {
    for (const auto& [name, value] : options_.controls) {
      const auto control = FindControl(name);
      if (control == controls_.end()) {
        std::string list = "format, size, fps, io, settle, queue";
        for (const V4l2Control& known : controls_)
          list += ", " + (known.short_name.empty() ? known.name : known.short_name);
        throw UsageError("'{}' has no option or control '{}'; known are: {}", uri_, name, list);
      }
      if (control->flags & V4L2_CTRL_FLAG_READ_ONLY)
        throw UsageError("'{}': the control {} is read-only", uri_, name);
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
    for (const std::string& words : frozen.held) Say(DeviceEventKind::kNotice, words);
    for (const std::string& words : frozen.refused) Say(DeviceEventKind::kNotice, words);
    for (const auto& [name, text] : options_.controls) {
      const V4l2Control& control = *FindControl(name);
      const int value = V4l2ControlValue(uri_, control, text);
      const int error = SetV4l2Control(*node_, control.id, value);
      const auto got = GetV4l2Control(*node_, control.id);
      if (error != 0 || (got && *got != value))
        Say(DeviceEventKind::kNotice, fmt::format("the camera changed {}={} to {}{}", name, text,
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
    const V4l2Patience& patience = options_.patience;
    const double stall_s = std::max(patience.stalled_s, patience.stalled_periods * configured_.period_s);
    const double lost_s = std::max(patience.lost_s, patience.lost_periods * configured_.period_s);
    const auto begun = Clock::now();
    auto last_frame = begun;
    bool stalled = false, settled = options_.settle_s == 0;
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
        if (stalled) {
          const double silence_s = SecondsSince(last_frame);
          Say(DeviceEventKind::kNotice, fmt::format("frames come again after {:.1f} s", silence_s),
              silence_s);
        }
        stalled = false;
        last_frame = Clock::now();
        continue;
      }
      if (error != EAGAIN) return Lose(V4l2Problem(node_->Path(), error));
      // Some drivers wake their readers before a buffer is filled.
      if (Pause(kEmptyPause)) return;
      const double silence_s = SecondsSince(last_frame);
      if (silence_s > stall_s && !std::exchange(stalled, true))
        Say(DeviceEventKind::kStalled, fmt::format("no frame for {:.1f} s", silence_s), silence_s);
      if (silence_s > lost_s)
        return Lose(
            fmt::format("no frame for {:.1f} s although the camera is connected; unplug it and plug it in "
                        "again, or use another USB socket",
                        silence_s));
    }
  }

  // True when the thread is to stop; else a frame may have arrived, or the time is over.
  bool WaitForFrame(milliseconds timeout) const {
    std::array<pollfd, 2> waiting{{{stop_, POLLIN, 0}, {node_->Descriptor(), POLLIN, 0}}};
    poll(waiting.data(), waiting.size(), static_cast<int>(timeout.count()));
    return waiting[0].revents != 0;
  }
  bool Pause(milliseconds time) const {
    pollfd waiting{stop_, POLLIN, 0};
    return poll(&waiting, 1, static_cast<int>(time.count())) > 0;
  }

  void Lose(const std::string& problem) {
    {
      const MutexLock lock(mutex_);
      info_.available = false;
      info_.problem = problem;
    }
    state_ = DeviceState::kLost;
    queue_->Close();
  }

  // Discards a frame; gaps between discarded frames count as missing too.
  void CountSettling(const V4l2Stream::Filled& filled) {
    const MutexLock lock(mutex_);
    ids_.Arrived(filled.header.sequence);
    ++while_settling_;
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
    {
      const MutexLock lock(mutex_);
      ids_.Arrived(frame.id);
      if (frame.status == FrameStatus::kIncomplete) ++statistics_.incomplete;
      if (monotonic) clock_.Add(stamp_s, frame.host_time_s);
    }
    queue_->Push(std::move(frame));
  }

  // False when the buffer does not contain the configured picture.
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
        Say(DeviceEventKind::kNotice, fmt::format("a frame is incomplete: {}", error.what()));
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
  std::unique_ptr<FrameQueue> queue_;
  int stop_ = -1;
  std::thread thread_;
  std::atomic<DeviceState> state_{DeviceState::kConnected};
  // Used by the capture thread.
  double exposure_s_ = 0;
  Clock::time_point settled_at_;
  bool said_incomplete_ = false;

  mutable Mutex mutex_;
  DeviceInfo info_ ULF_GUARDED_BY(mutex_);
  HeldAutomatics held_ ULF_GUARDED_BY(mutex_);
  DeviceStatistics statistics_ ULF_GUARDED_BY(mutex_);
  FrameIdCounter ids_ ULF_GUARDED_BY(mutex_);
  std::uint64_t while_settling_ ULF_GUARDED_BY(mutex_) = 0;
  ClockOffset clock_ ULF_GUARDED_BY(mutex_);
  Clock::time_point started_ ULF_GUARDED_BY(mutex_);
  std::vector<DeviceEvent> events_ ULF_GUARDED_BY(mutex_);
};

}  // namespace

std::unique_ptr<Device> OpenV4l2Device(const DeviceUri& uri) { return std::make_unique<V4l2Device>(uri); }

std::vector<DeviceInfo> ListV4l2Devices() {
  std::vector<DeviceInfo> list;
  for (const V4l2Camera& camera : FindV4l2Cameras()) list.push_back(camera.info);
  return list;
}

}  // namespace ulf::acquisition
