#include "acquisition/aravis/aravis_device.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <atomic>
#include <fstream>
#include <mutex>
#include <thread>
#include <utility>

#include "acquisition/aravis/aravis_calls.h"
#include "acquisition/aravis/aravis_configuration.h"
#include "acquisition/aravis/aravis_discovery.h"
#include "acquisition/aravis/aravis_session.h"
#include "acquisition/aravis/gige_vision_probe.h"
#include "acquisition/frame_id_counter.h"
#include "acquisition/frame_queue.h"

namespace ulf {
namespace {

using std::chrono::milliseconds;
using Clock = std::chrono::steady_clock;

const char* StatusText(ArvBufferStatus status) {
  switch (status) {
    case ARV_BUFFER_STATUS_SUCCESS:
      return "not the image that was configured";
    case ARV_BUFFER_STATUS_TIMEOUT:
      return "timed out";
    case ARV_BUFFER_STATUS_MISSING_PACKETS:
      return "packets lost";
    case ARV_BUFFER_STATUS_WRONG_PACKET_ID:
      return "wrong packet number";
    case ARV_BUFFER_STATUS_SIZE_MISMATCH:
      return "wrong size";
    default:
      return "never filled";
  }
}

class AravisDevice : public Device {
 public:
  explicit AravisDevice(const DeviceUri& uri) : options_(AravisOptionsOf(uri)) {
    const std::string open_by = ResolveAravis(uri.Text(), uri.path);
    info_.uri = uri.Text();
    if (uri.path.empty()) {
      DeviceUri named = uri;
      named.path = open_by;
      info_.uri = named.Text();
    }
    Open(open_by);
    configured_ = ConfigureAravis(*session_, info_.uri, options_);
    spdlog::debug("{}: {} {} {}x{} {}, exposure {} s, gain {:.3f}, period {:.4f} s", info_.uri, info_.maker,
                  info_.model, configured_.width, configured_.height, configured_.format.name,
                  configured_.exposure_s, configured_.gain, configured_.period_s);
  }

  ~AravisDevice() override { Stop(); }

  DeviceInfo Info() const override {
    const std::lock_guard lock(mutex_);
    return info_;
  }
  bool IsLive() const override { return true; }

  void Start() override {
    if (running_) return;
    if (!session_) throw Error("{}: {}; open the device again", info_.uri, info_.problem);
    CreateStream();
    queue_ = std::make_unique<FrameQueue>(options_.queue, WhenFull::kDropOldest);
    {
      const std::lock_guard lock(mutex_);
      statistics_ = {};
      ids_ = {};
    }
    state_ = DeviceState::kStreaming;
    first_of_stream_ = true;
    Must(info_.uri, "start of acquisition",
         [&](GError** e) { arv_camera_start_acquisition(session_->Camera(), e); });
    stop_ = false;
    running_ = true;
    thread_ = std::thread([this] {
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
      const std::lock_guard lock(mutex_);
      ++statistics_.delivered;
    }
    return frame;
  }

  void Stop() override {
    if (!running_) return;
    running_ = false;
    stop_ = true;
    thread_.join();
    queue_->Close();
    // A camera that died just now: every call to it would wait out its retries.
    const bool gone =
        !gige_address_.empty() && AskGigeControl(gige_address_, milliseconds(1000)) == GigeControl::kNoAnswer;
    if (gone && state_ != DeviceState::kLost) Lose("the camera no longer answers; check power and cable");
    if (state_ == DeviceState::kLost) {
      AravisSession::Bury(std::move(session_));
      return;
    }
    state_ = DeviceState::kEnded;
    Try([&](GError** e) { arv_camera_stop_acquisition(session_->Camera(), e); });
    session_->ReleaseStream();
  }

  DeviceState State() const override { return state_; }

  DeviceStatistics Statistics() const override {
    const std::lock_guard lock(mutex_);
    DeviceStatistics statistics = statistics_;
    statistics.missing = ids_.Missing();
    return statistics;
  }

 private:
  void Open(const std::string& open_by) {
    session_ = AravisSession::Open(info_.uri, open_by);
    if (!session_->IsController()) {
      // A program that was killed keeps control until its heartbeat has run out, three seconds after.
      Try([&](GError** e) { arv_gv_device_take_control(ARV_GV_DEVICE(session_->Device()), e); });
      if (!session_->IsController()) throw Error("{}: {}", info_.uri, session_->WhoControls());
    }
    gige_address_ = session_->GigeAddress();
    session_->Describe(info_);
  }

  void CreateStream() {
    session_->TakeStream(
        Must(info_.uri, "stream (does another program control this camera?)",
             [&](GError** e) { return arv_camera_create_stream(session_->Camera(), nullptr, nullptr, e); }));
    ArvStream* stream = session_->Stream();
    // The system's default receive buffer loses packets even on loopback, and the library's automatic one is
    // a single frame: too little for small frames. Two frames, and no less than two megabytes.
    if (ARV_IS_GV_STREAM(stream)) {
      const std::size_t bytes = std::clamp<std::size_t>(2 * configured_.payload_bytes, 2 << 20, 256 << 20);
      g_object_set(stream, "socket-buffer", ARV_GV_STREAM_SOCKET_BUFFER_FIXED, "socket-buffer-size",
                   static_cast<gint>(bytes), nullptr);
    }
    constexpr std::size_t kPoolBytes = 64 << 20;
    const std::size_t count =
        std::clamp<std::size_t>(kPoolBytes / std::max<std::size_t>(configured_.payload_bytes, 1), 4, 24);
    for (std::size_t i = 0; i < count; ++i)
      arv_stream_push_buffer(stream, arv_buffer_new_allocate(configured_.payload_bytes));
  }

  // The capture thread: from the library's buffers to the queue, until told to stop or the camera is gone.
  void Capture() {
    const double stall_s = std::max(0.5, 3 * configured_.period_s);
    const double lost_s = std::max(5.5, 10 * configured_.period_s);
    auto last_frame = Clock::now();
    bool stalled = false;
    while (!stop_) {
      ArvBuffer* buffer = arv_stream_timeout_pop_buffer(session_->Stream(), 50'000);
      if (buffer) {
        Take(buffer);
        arv_stream_push_buffer(session_->Stream(), buffer);
        if (stalled) spdlog::warn("{}: frames come again", info_.uri);
        stalled = false;
        last_frame = Clock::now();
      }
      if (session_->ControlLost()) {
        Lose("the camera no longer answers, or another program took control of it; check power and cable");
        break;
      }
      const double silence_s = std::chrono::duration<double>(Clock::now() - last_frame).count();
      if (silence_s > stall_s && !stalled) {
        stalled = true;
        spdlog::warn("{}: no frame for {:.1f} s", info_.uri, silence_s);
      }
      if (silence_s > lost_s) {
        Lose(fmt::format(
            "no frame for {:.1f} s although the control channel is open; check the firewall, the packet "
            "size (?packet_size=1400) and that no trigger is awaited",
            silence_s));
        break;
      }
    }
  }

  void Lose(const std::string& problem) {
    {
      const std::lock_guard lock(mutex_);
      info_.available = false;
      info_.problem = problem;
    }
    state_ = DeviceState::kLost;
    queue_->Close();
  }

  void Take(ArvBuffer* buffer) {
    const ArvBufferStatus status = arv_buffer_get_status(buffer);
    if (status == ARV_BUFFER_STATUS_CLEARED || status == ARV_BUFFER_STATUS_ABORTED)
      return;  // stopping, not a loss
    // The library widens its receive buffer when the first packet is there: a large first frame has lost some
    // by then.
    if (std::exchange(first_of_stream_, false) && status != ARV_BUFFER_STATUS_SUCCESS) return;
    const double host_time_s = 1e-9 * static_cast<double>(arv_buffer_get_system_timestamp(buffer));
    Frame frame;
    frame.id = arv_buffer_get_frame_id(buffer);
    frame.device_time_s = 1e-9 * static_cast<double>(arv_buffer_get_timestamp(buffer));
    frame.host_time_s = host_time_s;
    if (frame.device_time_s == 0) frame.device_time_s = host_time_s;  // a camera without a clock
    frame.exposure_s = configured_.exposure_s;
    frame.gain = configured_.gain;
    if (status == ARV_BUFFER_STATUS_SUCCESS && FillComplete(buffer, frame)) {
      frame.status = FrameStatus::kComplete;
    } else {
      frame.status = FrameStatus::kIncomplete;
      FillIncomplete(buffer, frame);
    }
    if (frame.status == FrameStatus::kIncomplete) ExplainLossOnce(frame.id, status);
    Count(frame);
    Queue(std::move(frame));
  }

  // False when the buffer does not hold the image that was configured.
  bool FillComplete(ArvBuffer* buffer, Frame& frame) {
    const auto format = PixelFormatByCode(arv_buffer_get_image_pixel_format(buffer));
    const int width = arv_buffer_get_image_width(buffer), height = arv_buffer_get_image_height(buffer);
    std::size_t size = 0;
    const void* data = arv_buffer_get_image_data(buffer, &size);
    gint x_padding = 0, y_padding = 0;
    arv_buffer_get_image_padding(buffer, &x_padding, &y_padding);
    if (!data || !format || width != configured_.width || height != configured_.height || x_padding != 0 ||
        size < ImageBytes(*format, width, height)) {
      if (!std::exchange(said_unexpected_, true))
        spdlog::warn(
            "{}: the camera sends {}x{} with format {:#010x} and row padding {}, but was set to {}x{} {}: "
            "its frames count as incomplete",
            info_.uri, width, height, arv_buffer_get_image_pixel_format(buffer), x_padding, configured_.width,
            configured_.height, configured_.format.name);
      return false;
    }
    frame.image = ImageFromBytes(*format, width, height, data, size);
    return true;
  }

  // For the eye only: what arrived, over what the buffer held before. Its own description cannot be trusted.
  void FillIncomplete(ArvBuffer* buffer, Frame& frame) {
    std::size_t received = 0;
    const void* data = arv_buffer_get_data(buffer, &received);
    const std::size_t needed = ImageBytes(configured_.format, configured_.width, configured_.height);
    if (data && needed <= configured_.payload_bytes)
      frame.image = ImageFromBytes(configured_.format, configured_.width, configured_.height, data, needed);
  }

  void ExplainLossOnce(std::uint64_t id, ArvBufferStatus status) {
    if (std::exchange(said_incomplete_, true)) return;
    long allowed = 0;
    std::ifstream("/proc/sys/net/core/rmem_max") >> allowed;
    const bool buffer_is_small =
        info_.bus == "GigEVision" &&
        allowed < static_cast<long>(std::min<std::size_t>(configured_.payload_bytes, 4 << 20));
    spdlog::warn("{}: frame {} arrived incomplete ({}); such frames are counted, not used{}", info_.uri, id,
                 StatusText(status),
                 buffer_is_small
                     ? fmt::format(". The system allows receive buffers of {} bytes only: 'sysctl "
                                   "net.core.rmem_max=8388608' as root lets more wait",
                                   allowed)
                     : "");
  }

  void Count(const Frame& frame) {
    const std::lock_guard lock(mutex_);
    // A frame whose first packet was lost has no number: 0 in a camera that counts from 1.
    if (frame.status == FrameStatus::kIncomplete && frame.id == 0)
      ids_.ArrivedWithoutId();
    else
      ids_.Arrived(frame.id);
    if (frame.status == FrameStatus::kIncomplete) ++statistics_.incomplete;
  }

  void Queue(Frame frame) {
    std::optional<Frame> made_room;
    queue_->Push(std::move(frame), &made_room);
    if (made_room && made_room->status == FrameStatus::kComplete) {
      const std::lock_guard lock(mutex_);
      ++statistics_.dropped;
    }
  }

  AravisOptions options_;
  DeviceInfo info_;           // problem and available under mutex_ while the thread runs
  std::string gige_address_;  // empty: another bus
  std::unique_ptr<AravisSession> session_;
  AravisConfigured configured_;
  std::unique_ptr<FrameQueue> queue_;
  std::thread thread_;
  std::atomic<bool> stop_{false};
  std::atomic<DeviceState> state_{DeviceState::kStreaming};
  bool running_ = false;
  bool first_of_stream_ = true;
  bool said_unexpected_ = false;
  bool said_incomplete_ = false;
  mutable std::mutex mutex_;
  DeviceStatistics statistics_;
  FrameIdCounter ids_;
};

}  // namespace

std::unique_ptr<Device> OpenAravisDevice(const DeviceUri& uri) { return std::make_unique<AravisDevice>(uri); }

}  // namespace ulf
