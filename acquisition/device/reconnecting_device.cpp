#include "acquisition/device/reconnecting_device.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <utility>

#include "acquisition/device/background_closer.h"
#include "acquisition/device/event_log.h"
#include "core/base/host_time.h"
#include "core/base/mutex.h"

namespace ulf::acquisition {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

// The shortest gap in device time between the last frame before a clock's restart and the first one after it.
constexpr double kShortestGapSeconds = 1e-3;

// The camera's clock continues where its times fit this computer's to within this, else it has restarted.
// Guessed: much more than jitter, much less than a restart takes.
constexpr double kSameClockS = 1;

// A frame waits no longer for its reader: where the computer's clock says that the gap was longer than the
// steady clock by more, it was set meanwhile. Guessed.
constexpr double kLongestWaitSeconds = 10;

void Add(const DeviceStatistics& more, DeviceStatistics& sum) {
  sum.delivered += more.delivered;
  sum.incomplete += more.incomplete;
  sum.dropped += more.dropped;
  sum.missing += more.missing;
  sum.out_of_order += more.out_of_order;
  sum.late += more.late;
  sum.reconnects += more.reconnects;
  sum.seconds += more.seconds;
  sum.bytes += more.bytes;
  if (more.clock_offset_s) sum.clock_offset_s = more.clock_offset_s;
  if (more.clock_jitter_s) sum.clock_jitter_s = more.clock_jitter_s;
  Add(more.transport, sum.transport);
}

// The size and kind of the images, which must be the same after a gap.
struct ImageKind {
  cv::Size size;
  int type = 0;
  Mosaic mosaic = Mosaic::kNone;

  static ImageKind Of(const Image& image) { return {image.pixels.size(), image.pixels.type(), image.mosaic}; }
  bool operator==(const ImageKind&) const = default;
  std::string Text() const {
    return fmt::format("{}x{}, {} channels of {} bits{}", size.width, size.height, CV_MAT_CN(type),
                       8 * CV_ELEM_SIZE1(type), mosaic == Mosaic::kNone ? "" : ", mosaic");
  }
};

class ReconnectingDevice : public Device {
 public:
  ReconnectingDevice(std::unique_ptr<Device> driver, Reconnection how)
      : how_(std::move(how)),
        camera_(driver->Camera()),
        window_(driver->Window()),
        live_(driver->IsLive()),
        takes_stills_(driver->TakesStills()),
        source_(driver->Source()),
        info_(driver->Info()),
        driver_(std::move(driver)) {}

  ~ReconnectingDevice() override {
    Stop();
    if (driver_ && IsOver(driver_->State())) CloseInBackground(std::move(driver_));
  }

  DeviceInfo Info() const override {
    const auto driver = Driver();
    if (driver && !problem_known_) return driver->Info();
    return LastInfo();
  }
  std::optional<CameraModel> Camera() const override { return camera_; }
  bool IsLive() const override { return live_; }
  FrameSource Source() const override { return source_; }
  std::optional<SensorWindow> Window() const override { return window_; }
  HeldAutomatics Held() const override {
    const auto driver = Driver();
    return driver ? driver->Held() : HeldAutomatics();
  }
  bool HasLiveFrames() const override {
    const auto driver = Driver();
    return !driver || driver->HasLiveFrames();
  }
  DeviceState State() const override { return state_; }
  bool TakesStills() const override { return takes_stills_; }
  std::optional<double> ShareDone() const override {
    const auto driver = Driver();
    return driver ? driver->ShareDone() : std::nullopt;
  }
  StillRequest RequestStill() override {
    const auto driver = Driver();
    return driver && state_ == DeviceState::kStreaming ? driver->RequestStill() : StillRequest::kBusy;
  }
  ExposureRequests TakesExposures() const override {
    const auto driver = Driver();
    return driver ? driver->TakesExposures() : ExposureRequests::kNone;
  }
  StillRequest RequestExposures(const std::vector<double>& stops) override {
    const auto driver = Driver();
    return driver && state_ == DeviceState::kStreaming ? driver->RequestExposures(stops)
                                                       : StillRequest::kBusy;
  }

  DeviceStatistics Statistics() const override {
    const auto driver = Driver();
    const MutexLock lock(mutex_);
    DeviceStatistics sum = past_;
    if (driver) Add(driver->Statistics(), sum);
    if (sum.clock_offset_s) *sum.clock_offset_s -= time_shift_s_;
    return sum;
  }

  std::vector<DeviceEvent> TakeEvents() override {
    if (const auto driver = Driver()) TakeEventsOf(*driver);
    return events_.Take();
  }

  void Start() override;
  void Stop() override;
  std::optional<Frame> Next(milliseconds timeout) override;

 private:
  std::shared_ptr<Device> Driver() const {
    const MutexLock lock(mutex_);
    return driver_;
  }
  DeviceInfo LastInfo() const {
    const MutexLock lock(mutex_);
    return info_;
  }
  double TimeShiftSeconds() const {
    const MutexLock lock(mutex_);
    return time_shift_s_;
  }
  void TakeEventsOf(Device& driver);
  void Retire();
  void Fault(const std::string& problem);
  void BeginSearch(Clock::time_point begin);
  void SearchAgain(const std::string& problem);
  void GiveUp(const std::string& problem);
  bool TakeFoundDriver(milliseconds timeout);
  std::optional<Frame> Deliver(Frame frame);
  double SecondsWithoutFrames(const Frame& next) const;
  std::string AlignClock(const Frame& frame);

  const Reconnection how_;
  const std::optional<CameraModel> camera_;
  const std::optional<SensorWindow> window_;
  const bool live_, takes_stills_;
  const FrameSource source_;

  std::atomic<DeviceState> state_{DeviceState::kConnected};
  std::atomic<bool> problem_known_{false};  // info_ holds the problem; the driver does not know it
  EventLog events_;
  mutable Mutex mutex_;
  // The last open driver's, with the problem while there is none.
  DeviceInfo info_ ULF_GUARDED_BY(mutex_);
  std::shared_ptr<Device> driver_ ULF_GUARDED_BY(mutex_);  // null while it is searched for
  DeviceStatistics past_ ULF_GUARDED_BY(mutex_);           // of closed drivers
  double time_shift_s_ ULF_GUARDED_BY(mutex_) = 0;         // session's time - driver's time

  // Used by the thread that calls Next() alone.
  std::shared_ptr<DriverSearch> search_;
  Clock::time_point fault_began_, give_up_;
  bool awaiting_first_ = false;  // the first frame of a driver that was found again
  std::string refused_;          // the last refusal that was reported
  std::optional<ImageKind> kind_;
  std::optional<double> last_device_time_s_, last_host_time_s_;
  Clock::time_point last_frame_at_;
};

// Passes on the driver's events, except those about the connection, which this class reports itself.
void ReconnectingDevice::TakeEventsOf(Device& driver) {
  for (DeviceEvent& event : driver.TakeEvents())
    if (event.kind == DeviceEventKind::kStalled || event.kind == DeviceEventKind::kNotice)
      events_.Pass(std::move(event));
}

void ReconnectingDevice::Start() {
  if (state_ != DeviceState::kConnected && state_ != DeviceState::kLost) return;
  std::shared_ptr<Device> driver = Driver();
  if (!driver) {
    std::string refused;
    driver = FindAgain(how_, LastInfo(), 0, &refused);
  } else {
    driver->Start();
  }
  {
    const MutexLock lock(mutex_);
    past_ = {};
    time_shift_s_ = 0;
    info_ = driver->Info();
    driver_ = std::move(driver);
  }
  events_.Take();
  problem_known_ = false;
  awaiting_first_ = false;
  kind_.reset();
  last_device_time_s_.reset();
  last_host_time_s_.reset();
  state_ = DeviceState::kStreaming;
}

void ReconnectingDevice::Stop() {
  if (search_) {
    const MutexLock lock(search_->mutex);
    search_->stop = true;
    search_->changed.notify_all();
    CloseInBackground(std::move(search_->found));
  }
  search_.reset();
  const bool running = state_ != DeviceState::kConnected && state_ != DeviceState::kLost;
  if (!running) return;
  if (auto driver = Driver()) {
    const bool over = IsOver(driver->State());
    if (!over) driver->Stop();
    driver.reset();  // Retire() must hold the last reference
    if (over) Retire();
  }
  state_ = DeviceState::kConnected;
}

// Keeps the statistics of the lost driver and closes it in the background.
void ReconnectingDevice::Retire() {
  std::shared_ptr<Device> dead = Driver();
  TakeEventsOf(*dead);
  const DeviceStatistics statistics = dead->Statistics();
  const DeviceInfo info = dead->Info();
  {
    const MutexLock lock(mutex_);
    Add(statistics, past_);
    info_ = info;
    driver_.reset();
  }
  problem_known_ = true;
  CloseInBackground(std::move(dead));
}

void ReconnectingDevice::Fault(const std::string& problem) {
  {
    const MutexLock lock(mutex_);
    info_.problem = problem;
    info_.available = false;
  }
  fault_began_ = Clock::now();
  give_up_ = fault_began_ + DurationOf(how_.patience_s);
  if (how_.patience_s <= 0) {
    events_.Say(DeviceEventKind::kFaulted, problem);
    state_ = DeviceState::kLost;
    return;
  }
  events_.Say(DeviceEventKind::kFaulted,
              fmt::format("{}; ulf tries to open it again for up to {:g} s", problem, how_.patience_s));
  state_ = DeviceState::kFaulted;
  BeginSearch(fault_began_);
}

// Continues the search after a driver was found that cannot be used.
void ReconnectingDevice::SearchAgain(const std::string& problem) {
  if (Clock::now() >= give_up_)
    GiveUp(problem);
  else
    BeginSearch(Clock::now() + DurationOf(kLongestSearchPauseS));
}

void ReconnectingDevice::GiveUp(const std::string& problem) {
  events_.Say(DeviceEventKind::kFaulted, fmt::format("{}: given up after {:.0f} s: {}", LastInfo().uri,
                                                     SecondsSince(fault_began_), problem));
  state_ = DeviceState::kLost;
}

void ReconnectingDevice::BeginSearch(Clock::time_point begin) {
  search_ = SearchDriver(how_, LastInfo(), begin, give_up_);
}

// Takes over the driver that the search has found; false: none yet.
bool ReconnectingDevice::TakeFoundDriver(milliseconds timeout) {
  std::unique_ptr<Device> found;
  std::string refused, problem;
  bool over = false;
  {
    MutexLock lock(search_->mutex);
    search_->changed.wait_for(lock, timeout, [this]() ULF_REQUIRES(search_->mutex) {
      return search_->found || search_->over || search_->refused != refused_;
    });
    found = std::move(search_->found);
    over = search_->over;
    refused = search_->refused;
    problem = search_->problem;
  }
  if (!refused.empty() && refused != refused_) {
    refused_ = refused;
    events_.Say(DeviceEventKind::kNotice, refused);
  }
  if (found) {
    search_.reset();
    awaiting_first_ = true;
    const MutexLock lock(mutex_);
    driver_ = std::move(found);
    return true;
  }
  if (over) {
    search_.reset();
    GiveUp(problem);
  }
  return false;
}

// From the last usable frame to `next` by this computer's clock; before the first one since the fault was
// noticed, which is later than the camera went: drivers wait for an answer before they call it lost.
double ReconnectingDevice::SecondsWithoutFrames(const Frame& next) const {
  if (!last_host_time_s_) return SecondsSince(fault_began_);
  const double gap_s = SecondsSince(last_frame_at_);
  const double host_gap_s = next.host_time_s - *last_host_time_s_;
  const bool is_plausible =
      *last_host_time_s_ > 0 && host_gap_s > 0 && host_gap_s < gap_s + kLongestWaitSeconds;
  return is_plausible ? host_gap_s : gap_s;
}

// Shifts times where the camera's clock has restarted. Returns a text for the event.
std::string ReconnectingDevice::AlignClock(const Frame& frame) {
  if (!last_device_time_s_) return "";
  const double expected_s = *last_device_time_s_ + std::max(SecondsWithoutFrames(frame), kShortestGapSeconds);
  const double time_s = frame.device_time_s + TimeShiftSeconds();
  const bool same_clock =
      time_s > *last_device_time_s_ && (!live_ || std::abs(time_s - expected_s) < kSameClockS);
  if (same_clock) return "";
  const MutexLock lock(mutex_);
  time_shift_s_ = expected_s - frame.device_time_s;
  return fmt::format("; its clock restarted: ulf adds {:.3f} s to its times", time_shift_s_);
}

std::optional<Frame> ReconnectingDevice::Deliver(Frame frame) {
  const bool complete_live = frame.status == FrameStatus::kComplete && frame.kind == FrameKind::kLive;
  if (complete_live && awaiting_first_) {
    const ImageKind kind = ImageKind::Of(frame.image);
    if (kind_ && !(kind == *kind_)) {
      const std::string text =
          fmt::format("{}: came back with other images ({}; before: {}); restore its earlier settings",
                      LastInfo().uri, kind.Text(), kind_->Text());
      if (text != std::exchange(refused_, text)) events_.Say(DeviceEventKind::kNotice, text);
      Retire();
      awaiting_first_ = false;
      SearchAgain(text);
      return std::nullopt;
    }
    awaiting_first_ = false;
    const std::string clock = AlignClock(frame);
    {
      const MutexLock lock(mutex_);
      ++past_.reconnects;
      info_.problem.clear();
      info_.available = true;
    }
    problem_known_ = false;
    refused_.clear();
    state_ = DeviceState::kStreaming;
    events_.Say(
        DeviceEventKind::kRestored,
        fmt::format("{}: streams again, {:.1f} s after {}{}", LastInfo().uri, SecondsWithoutFrames(frame),
                    last_host_time_s_ ? "its last frame" : "it was lost", clock));
  }
  const double time_shift_s = TimeShiftSeconds();
  frame.device_time_s += time_shift_s;
  if (frame.requested_s) *frame.requested_s += time_shift_s;
  if (complete_live) {
    if (!kind_) kind_ = ImageKind::Of(frame.image);
    last_device_time_s_ = frame.device_time_s;
    last_host_time_s_ = frame.host_time_s;
    last_frame_at_ = Clock::now();
  }
  return frame;
}

std::optional<Frame> ReconnectingDevice::Next(milliseconds timeout) {
  // A stopped tethered camera still delivers the photographs that it was downloading.
  if (state_ == DeviceState::kConnected && takes_stills_)
    if (const auto driver = Driver()) return driver->Next(timeout);
  if (state_ == DeviceState::kConnected || IsOver(state_)) return std::nullopt;
  const auto until = Clock::now() + timeout;
  if (state_ == DeviceState::kFaulted) {
    state_ = DeviceState::kReconnecting;
    events_.Say(DeviceEventKind::kReconnecting, fmt::format("{}: searching for the camera", LastInfo().uri));
  }
  if (search_ && !TakeFoundDriver(timeout)) return std::nullopt;
  const auto left = std::max(milliseconds(0), std::chrono::duration_cast<milliseconds>(until - Clock::now()));
  auto driver = Driver();
  auto frame = driver->Next(left);
  const DeviceState state = frame ? DeviceState::kStreaming : driver->State();
  const std::string problem = state == DeviceState::kLost ? driver->Info().problem : "";
  driver.reset();  // Retire() must hold the last reference
  if (frame) return Deliver(std::move(*frame));
  if (state == DeviceState::kEnded) state_ = DeviceState::kEnded;
  if (state == DeviceState::kLost) {
    Retire();
    if (std::exchange(awaiting_first_, false))
      SearchAgain("it was lost again before its first frame: " + problem);
    else
      Fault(
          fmt::format("{}: {}", LastInfo().uri, problem.empty() ? "the camera no longer answers" : problem));
  }
  return std::nullopt;
}

}  // namespace

std::unique_ptr<Device> MakeReconnectingDevice(std::unique_ptr<Device> driver, Reconnection reconnection) {
  return std::make_unique<ReconnectingDevice>(std::move(driver), std::move(reconnection));
}

}  // namespace ulf::acquisition
