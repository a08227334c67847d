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
#include "acquisition/frame_id_counter.h"
#include "acquisition/frame_queue.h"
#include "acquisition/aravis/gige_vision_probe.h"

namespace ulf {
namespace {

using std::chrono::milliseconds;
using Clock = std::chrono::steady_clock;

struct Discovered {
  std::string id, physical_id, address, vendor, model, serial, protocol;

  bool IsGige() const { return protocol == "GigEVision"; }
  // GigE Vision opens by address: at once, and through the network that leads there.
  std::string OpenBy() const { return IsGige() && !address.empty() ? address : id; }
  bool Answers(const std::string& name) const {
    return name == id || name == serial || name == physical_id || name == address ||
           name == vendor + "-" + serial || name == vendor + "-" + model + "-" + serial;
  }
};

std::vector<Discovered> Discover() {
  static std::mutex mutex;  // the library's list is one for the process
  const std::lock_guard lock(mutex);
  arv_update_device_list();
  std::vector<Discovered> found;
  for (unsigned i = 0; i < arv_get_n_devices(); ++i)
    found.push_back({Text(arv_get_device_id(i)), Text(arv_get_device_physical_id(i)),
                     Text(arv_get_device_address(i)), Text(arv_get_device_vendor(i)),
                     Text(arv_get_device_model(i)), Text(arv_get_device_serial_nbr(i)),
                     Text(arv_get_device_protocol(i))});
  return found;
}

bool IsIpv4(const std::string& text) {
  if (text.find('.') == std::string::npos || !g_hostname_is_ip_address(text.c_str())) return false;
  return text.find(':') == std::string::npos;
}

// What to open for the ID of a URI.
std::string Resolve(const std::string& uri, const std::string& id) {
  if (IsIpv4(id)) return id;
  const std::vector<Discovered> found = Discover();
  if (found.empty())
    throw Error(
        "{}: no camera answers; looked for GigE Vision on every network and for USB3 Vision. Check power, "
        "cable "
        "and firewall (UDP port 3956), name the camera's address if it is behind a router, or use sim:studio",
        uri);
  if (id.empty()) return found.front().OpenBy();
  std::vector<Discovered> matching;
  std::string list;
  for (const Discovered& camera : found) {
    if (camera.Answers(id)) matching.push_back(camera);
    list += fmt::format("{}{} (serial {}, {})", list.empty() ? "" : "; ", camera.id, camera.serial,
                        camera.OpenBy());
  }
  if (matching.empty()) throw Error("{}: no camera is named '{}'; found are: {}", uri, id, list);
  const bool ambiguous = std::any_of(matching.begin(), matching.end(), [&](const Discovered& camera) {
    return camera.physical_id != matching.front().physical_id;
  });
  if (ambiguous) throw Error("{}: '{}' names more than one camera; say which by address: {}", uri, id, list);
  return matching.front().OpenBy();
}

// The signal handler may run in the library's heartbeat thread while another thread lets go: if the last
// reference then falls inside the emission, the library waits for its own thread and aborts. So the handler
// only sets a flag, and letting go disconnects it, waits until it is out, and gives the emission time to
// return.
class Session {
 public:
  explicit Session(ArvCamera* camera) : camera_(camera) {
    if (ARV_IS_GV_DEVICE(Device()) || ARV_IS_UV_DEVICE(Device()))
      handler_ = g_signal_connect(Device(), "control-lost", G_CALLBACK(&Session::OnControlLost), this);
  }
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  ~Session() {
    if (handler_) g_signal_handler_disconnect(Device(), handler_);
    while (inside_handler_.load() > 0) std::this_thread::sleep_for(milliseconds(1));
    std::this_thread::sleep_for(milliseconds(50));
    ReleaseStream();
    g_object_unref(camera_);
  }

  ArvCamera* Camera() const { return camera_; }
  ArvDevice* Device() const { return arv_camera_get_device(camera_); }
  ArvStream* Stream() const { return stream_; }
  void TakeStream(ArvStream* stream) { stream_ = stream; }
  void ReleaseStream() { g_clear_object(&stream_); }
  bool ControlLost() const { return control_lost_.load(); }
  bool IsController() const {
    return !ARV_IS_GV_DEVICE(Device()) || arv_gv_device_is_controller(ARV_GV_DEVICE(Device()));
  }

 private:
  static void OnControlLost(ArvDevice* /*device*/, gpointer self) {
    auto* session = static_cast<Session*>(self);
    ++session->inside_handler_;
    session->control_lost_ = true;
    --session->inside_handler_;
  }

  ArvCamera* camera_;
  ArvStream* stream_ = nullptr;
  gulong handler_ = 0;
  std::atomic<bool> control_lost_{false};
  std::atomic<int> inside_handler_{0};
};

// Lets go of cameras that are gone: each call to them waits out its retries, seconds in all.
class Reaper {
 public:
  static Reaper& Instance() {
    static Reaper reaper;
    return reaper;
  }
  ~Reaper() {
    for (std::thread& thread : threads_) thread.join();
  }
  void Bury(std::unique_ptr<Session> session) {
    const std::lock_guard lock(mutex_);
    threads_.emplace_back([session = std::move(session)]() mutable { session.reset(); });
  }

 private:
  std::mutex mutex_;
  std::vector<std::thread> threads_;
};

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
    const std::string open_by = Resolve(uri.Text(), uri.path);
    info_.uri = uri.Text();
    if (uri.path.empty()) {
      DeviceUri named = uri;
      named.path = open_by;
      info_.uri = named.Text();
    }
    Open(open_by);
    configured_ = ConfigureAravis(session_->Camera(), info_.uri, options_);
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
      Reaper::Instance().Bury(std::move(session_));
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
    ArvCamera* camera =
        Must(info_.uri, "cannot be opened (check power, cable and address; 'ulf devices' lists what answers)",
             [&](GError** e) { return arv_camera_new(open_by.c_str(), e); });
    session_ = std::make_unique<Session>(camera);
    if (!session_->IsController()) {
      // A program that was killed keeps control until its heartbeat has run out, three seconds after.
      Try([&](GError** e) { arv_gv_device_take_control(ARV_GV_DEVICE(session_->Device()), e); });
      if (!session_->IsController())
        throw Error(
            "{}: another program controls this camera; close it (its control ends some seconds later), then "
            "try "
            "again",
            info_.uri);
    }
    if (arv_camera_is_gv_device(camera)) gige_address_ = AravisGigeAddress(camera);
    info_.maker = Text(Maybe([&](GError** e) { return arv_camera_get_vendor_name(camera, e); }, ""));
    info_.model = Text(Maybe([&](GError** e) { return arv_camera_get_model_name(camera, e); }, ""));
    info_.serial =
        Text(Maybe([&](GError** e) { return arv_camera_get_device_serial_number(camera, e); }, ""));
    info_.bus = arv_camera_is_gv_device(camera)        ? "GigEVision"
                : ARV_IS_UV_DEVICE(session_->Device()) ? "USB3Vision"
                                                       : "";
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
  std::unique_ptr<Session> session_;
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

std::vector<DeviceInfo> ListAravisDevices() {
  std::vector<DeviceInfo> list;
  for (const Discovered& camera : Discover()) {
    DeviceInfo info{.uri = "aravis:" + camera.OpenBy(),
                    .maker = camera.vendor,
                    .model = camera.model,
                    .serial = camera.serial,
                    .bus = camera.protocol,
                    .problem = ""};
    if (camera.IsGige()) {
      const GigeControl control = AskGigeControl(camera.address);
      if (control == GigeControl::kControlled)
        info.problem = "another program controls it; close that program, its control ends some seconds later";
      if (control == GigeControl::kNoAnswer)
        info.problem = "answers discovery but not at its own address " + camera.address +
                       "; give the camera and this computer's network interface addresses in one network";
    }
    info.available = info.problem.empty();
    list.push_back(info);
  }
  return list;
}

}  // namespace ulf
