#include "acquisition/aravis/aravis_device.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <atomic>
#include <utility>

#include "acquisition/aravis/aravis_automatics.h"
#include "acquisition/aravis/aravis_calls.h"
#include "acquisition/aravis/aravis_clock.h"
#include "acquisition/aravis/aravis_configuration.h"
#include "acquisition/aravis/aravis_exposures.h"
#include "acquisition/aravis/aravis_frames.h"
#include "acquisition/aravis/aravis_session.h"
#include "acquisition/aravis/aravis_stream.h"
#include "acquisition/aravis/aravis_usb.h"
#include "acquisition/aravis/aravis_watch.h"
#include "acquisition/aravis/aravis_white_balance.h"
#include "acquisition/device/background_closer.h"
#include "acquisition/device/live_driver.h"
#include "acquisition/gige_vision/gige_vision_probe.h"
#include "core/base/host_time.h"

namespace ulf::acquisition {
namespace {

using std::chrono::milliseconds;
using Clock = std::chrono::steady_clock;

// How long the capture thread waits for a frame before it does its other work, how long it waits for the
// camera's answer about its control at Stop(), the pause between two readings of the library's counters, and
// after how many broken frames at the beginning chunk data are given up. All guessed.
constexpr std::uint64_t kFrameWaitMicroseconds = 50'000;
constexpr milliseconds kAskAtStop(500);
constexpr double kCountersEverySeconds = 0.1;
constexpr int kBrokenByChunks = 3;
// A software trigger without a frame is fired again after at least so many seconds. Guessed.
constexpr double kTriggerPatienceS = 1;

class AravisDevice : public LiveDriver {
 public:
  explicit AravisDevice(const DeviceUri& uri) : options_(AravisOptionsOf(uri)) {
    const std::string open_by = ResolveAravis(uri.Text(), uri.path);
    DeviceUri named = uri;
    if (uri.path.empty()) named.path = open_by;
    info_.uri = uri_ = named.Text();
    events_.LogAs(uri_);
    Open(open_by);
    configured_ = ConfigureAravis(*session_, uri_, options_);
    spdlog::debug("{}: {} {} {}x{} {}, exposure {} s, gain {:.3f}, period {:.4f} s", uri_, info_.maker,
                  info_.model, configured_.width, configured_.height, configured_.format.name,
                  configured_.exposure_s, configured_.gain, configured_.period_s);
    if (session_->IsUsb())
      if (const auto place = UsbCameraPlaceOf(info_.maker, info_.serial))
        if (const std::string slow = SlowUsbText(*place, configured_.payload_bytes); !slow.empty())
          events_.Notice("the camera is " + slow);
    clock_of_camera_.emplace(*session_, uri_, options_, configured_.notes);
    for (const std::string& note : configured_.notes) events_.Notice(fmt::format("the camera {}", note));
  }

  ~AravisDevice() override { Stop(); }

  DeviceInfo Info() const override {
    const MutexLock lock(mutex_);
    DeviceInfo info = info_;
    if (!held_uri_.empty()) info.uri = held_uri_;
    return info;
  }
  HeldAutomatics Held() const override {
    if (some_stay_on_) return {};
    const auto held = [](const std::optional<bool>& asked_on) { return !asked_on.value_or(false); };
    return {.exposure = held(options_.auto_exposure) && held(options_.auto_gain),
            .white_balance = held(options_.auto_white_balance),
            .focus = {}};
  }
  std::optional<SensorWindow> Window() const override { return configured_.window; }
  ExposureRequests TakesExposures() const override {
    return exposures_ ? exposures_->Kind() : ExposureRequests::kNone;
  }
  StillRequest RequestExposures(const std::vector<double>& stops) override {
    if (!exposures_ || state_ != DeviceState::kStreaming) return StillRequest::kBusy;
    RememberExposure();
    return exposures_->Request(stops);
  }

  void Start() override;
  std::optional<Frame> Next(milliseconds timeout) override;
  void Stop() override;

  DeviceStatistics Statistics() const override {
    DeviceStatistics statistics = statistics_.Now();
    {
      const MutexLock lock(mutex_);
      statistics.transport = transport_;
    }
    statistics.transport.insert(
        statistics.transport.begin(),
        {TransportFigure::kPixelRate,
         statistics.seconds > 0 ? 1e-6 * static_cast<double>(statistics.bytes) / statistics.seconds : 0});
    return statistics;
  }

 private:
  void Open(const std::string& open_by);
  void Capture();
  bool ChunksFail() const;
  void GiveUpChunks();
  void Take(ArvBuffer* buffer);
  void CountSettling(ArvBuffer* buffer, ArvBufferStatus status);
  void CountId(ArvBuffer* buffer, FrameStatus status);
  void Freeze();
  void ExplainLossOnce(std::uint64_t id, ArvBufferStatus status);
  void Fire();
  void Lose(const std::string& problem);

  // A camera that is lost in the middle of a bracket is opened again with the exposure before.
  void RememberExposure() {
    const MutexLock lock(mutex_);
    DeviceUri uri = DeviceUri::Parse(held_uri_.empty() ? uri_ : held_uri_);
    if (uri.Option("exposure_us")) return;
    uri.Set("exposure_us", fmt::format("{:g}", 1e6 * configured_.exposure_s));
    held_uri_ = uri.Text();
  }
  void RememberTransport() {
    auto transport = stream_->Transport();
    clock_of_camera_->AppendTo(transport);
    const MutexLock lock(mutex_);
    if (configured_.exposure_s > 0)
      transport.emplace_back(TransportFigure::kExposureUs, 1e6 * configured_.exposure_s);
    transport.emplace_back(TransportFigure::kWrongPacketIds, static_cast<double>(wrong_packet_ids_));
    transport.emplace_back(TransportFigure::kWhileSettling, statistics_.WhileSettlingCount());
    transport_ = std::move(transport);
  }
  // Returns whether frames are expected: always without a trigger, else from firing to the frame.
  bool TellsExposures() const {
    return std::find(configured_.chunks.begin(), configured_.chunks.end(), "ExposureTime") !=
           configured_.chunks.end();
  }
  bool FramesAreDue() const { return !options_.Triggered() || trigger_out_; }

  AravisOptions options_;
  std::string uri_;           // as it was opened
  std::string gige_address_;  // empty: another bus
  std::unique_ptr<AravisSession> session_;
  AravisConfigured configured_;
  std::optional<AravisClock> clock_of_camera_;
  std::unique_ptr<AravisStream> stream_;
  std::unique_ptr<AravisFrames> frames_;
  std::unique_ptr<AravisExposures> exposures_;
  std::atomic<bool> stop_{false};
  std::atomic<bool> running_{false};

  // A software trigger is open: set by Next(), cleared when its frame arrives.
  std::atomic<bool> trigger_out_{false};
  std::atomic<Clock::time_point> triggered_at_{Clock::time_point{}};

  // Used by the capture thread.
  bool first_of_stream_ = true;
  bool one_was_whole_ = false;  // of this stream
  int broken_ = 0;              // before the first that was
  bool said_incomplete_ = false;
  std::optional<Clock::time_point> settled_at_;  // frames until then are discarded; none: none are

  std::atomic<bool> some_stay_on_{false};  // automatics that could not be switched off

  TransportFigures transport_ ULF_GUARDED_BY(mutex_);  // as they were remembered last
  std::uint64_t wrong_packet_ids_ ULF_GUARDED_BY(mutex_) = 0;
  // Returns the URI with the values that the automatics had reached; empty: uri_.
  std::string held_uri_ ULF_GUARDED_BY(mutex_);
};

void AravisDevice::Open(const std::string& open_by) {
  session_ = AravisSession::Open(uri_, open_by, AravisSession::Wanted::kControl);
  // Another program may have taken control meanwhile.
  if (!session_->IsController()) throw Error("{}: {}", uri_, session_->WhoControls());
  gige_address_ = session_->GigeAddress();
  const MutexLock lock(mutex_);
  session_->Describe(info_);
}

void AravisDevice::Start() {
  if (running_) return;
  if (!session_) throw Error("{}: {}; open the device again", uri_, Info().problem);
  stream_ = std::make_unique<AravisStream>(*session_, uri_, options_, configured_);
  frames_ = std::make_unique<AravisFrames>(*session_, configured_);
  queue_ = std::make_unique<FrameQueue>(options_.queue);
  {
    const MutexLock lock(mutex_);
    transport_.clear();
    wrong_packet_ids_ = 0;
  }
  statistics_.Begin();
  first_of_stream_ = true;
  one_was_whole_ = false;
  broken_ = 0;
  trigger_out_ = false;
  settled_at_.reset();
  exposures_ = std::make_unique<AravisExposures>(*session_, TellsExposures(), options_.SoftwareTriggered());
  if (HasAutomaticOn(*session_, options_)) {
    // Automatics do not settle on a camera that waits for triggers.
    if (options_.Triggered() || options_.settle_s == 0)
      Freeze();
    else
      settled_at_ = Clock::now() + DurationOf(options_.settle_s);
  }
  CallOrThrow(uri_, "start of acquisition", arv_camera_start_acquisition, session_->Camera());
  if (options_.white_balance && options_.white_balance->by_camera) BalanceWhiteOnce(*session_, uri_);
  stop_ = false;
  state_ = DeviceState::kStreaming;
  running_ = true;
  thread_ = ReadingThread([this] { Capture(); },
                          [this](const std::string& why) { Lose("reading its frames failed: " + why); });
}

std::optional<Frame> AravisDevice::Next(milliseconds timeout) {
  if (options_.SoftwareTriggered() && state_ == DeviceState::kStreaming && queue_->Size() == 0) Fire();
  return LiveDriver::Next(timeout);
}

// From then on Info().uri has the values that they reached, so that a camera opened by it takes the same
// pictures.
void AravisDevice::Freeze() {
  const AravisFrozen frozen = FreezeAravisAutomatics(*session_, options_);
  some_stay_on_ = HasAutomaticOn(*session_, options_);
  for (const std::string& words : frozen.said) events_.Notice(words);
  ReadLight(*session_, uri_, configured_);
  frames_->SetLight(configured_);
  exposures_->LookAgain();
  if (frozen.values.empty()) return;
  const MutexLock lock(mutex_);
  DeviceUri uri = DeviceUri::Parse(uri_);
  for (const auto& [option, value] : frozen.values) uri.Set(option, value);
  held_uri_ = uri.Text();
}

// Fires a trigger unless the frame of the last one is still to come and not yet overdue.
void AravisDevice::Fire() {
  const double overdue_s = std::max(kTriggerPatienceS, kStallPeriods * configured_.period_s);
  if (trigger_out_ && SecondsSince(triggered_at_) < overdue_s) return;
  triggered_at_ = Clock::now();
  trigger_out_ = true;
  if (const auto failure = FailureOf(arv_camera_software_trigger, session_->Camera()))
    spdlog::debug("{}: software trigger: {}", uri_, *failure);  // the watch finds the cause
}

void AravisDevice::Stop() {
  if (!running_) return;
  stop_ = true;
  thread_.join();
  statistics_.End();
  running_ = false;
  queue_->Close();
  // Asks first, because every call to a camera that is gone waits for all its retries.
  const bool gone =
      !gige_address_.empty() && QueryGigeControl(gige_address_, kAskAtStop) == GigeControl::kNoAnswer;
  if (gone && state_ != DeviceState::kLost) Lose("the camera no longer answers; check power and cable");
  if (!gone) exposures_->Restore();
  exposures_.reset();
  frames_.reset();
  stream_.reset();
  if (state_ == DeviceState::kLost && (gone || gige_address_.empty())) {
    CloseInBackground(std::move(session_));
    return;
  }
  FailureOf(arv_camera_stop_acquisition, session_->Camera());
  session_->ReleaseStream();
  if (state_ == DeviceState::kLost)
    session_.reset();  // the camera answers: returns control at once
  else
    state_ = DeviceState::kConnected;
}

// The capture thread: moves frames from the library's buffers to the queue until Stop() or the camera is
// lost.
void AravisDevice::Capture() {
  AravisWatch watch(*session_, configured_.period_s);
  StallReport stall(events_);
  auto remembered = Clock::time_point{};
  bool frozen = false;
  while (!stop_) {
    ArvBuffer* buffer = arv_stream_timeout_pop_buffer(session_->Stream(), kFrameWaitMicroseconds);
    if (settled_at_ && Clock::now() >= *settled_at_ && !frozen) {
      frozen = true;
      Freeze();
      // Frames that were exposed before the automatics were off still arrive.
      settled_at_ = Clock::now() + DurationOf(configured_.period_s + configured_.exposure_s);
    }
    if (frozen && settled_at_ && Clock::now() >= *settled_at_) settled_at_.reset();
    exposures_->Step();
    if (buffer) {
      Take(buffer);
      arv_stream_push_buffer(session_->Stream(), buffer);
      if (!options_.Triggered()) watch.FrameCame(SecondsSince(stall.LastFrame()));
      stall.FrameCame();
      if (ChunksFail()) GiveUpChunks();
    }
    if (SecondsSince(remembered) > kCountersEverySeconds) {
      RememberTransport();
      remembered = Clock::now();
    }
    for (std::string& note : stream_->TakeNotes(!first_of_stream_)) events_.Notice(std::move(note));
    if (const auto words = buffer ? clock_of_camera_->Poll() : std::nullopt)  // a camera that is gone blocks
      events_.Notice(*words);
    const auto since = FramesAreDue() ? std::max(stall.LastFrame(), triggered_at_.load()) : Clock::now();
    const double silence_s = SecondsSince(since);
    if (stall.NoFrame(silence_s, watch.StallSeconds()) && stream_->RefusedPackets() > 0 &&
        stream_->AllowAnyPort())
      events_.Notice(
          "the camera sends packets from another port than it reports: from now on ulf checks only their "
          "address");
    if (!FramesAreDue()) stall.EndStall();
    const bool waits_for_trigger = options_.Triggered() && !trigger_out_;
    if (const auto why = watch.LossReason(silence_s, waits_for_trigger, stream_->RefusedPackets())) {
      Lose(*why);
      break;
    }
  }
  RememberTransport();
}

// A USB3 Vision camera that promises chunk data and sends none sends less than was agreed, and the library
// takes none of its frames for a whole one. On GigE Vision it does (AravisFrames).
bool AravisDevice::ChunksFail() const {
  return session_->IsUsb() && !configured_.chunks.empty() && broken_ >= kBrokenByChunks && !one_was_whole_;
}

// Begins the stream again without chunk data.
void AravisDevice::GiveUpChunks() {
  events_.Notice(fmt::format(
      "chunk data are switched on, but none of the first frames ({}) came whole: the camera perhaps "
      "sends none. They are switched off, and exposure, gain and time are taken from the settings and "
      "the stream (chunks=off says so from the start)",
      broken_));
  FailureOf(arv_camera_stop_acquisition, session_->Camera());
  frames_.reset();
  stream_.reset();
  session_->ReleaseStream();
  SwitchChunksOff(*session_, uri_, configured_);
  stream_ = std::make_unique<AravisStream>(*session_, uri_, options_, configured_);
  frames_ = std::make_unique<AravisFrames>(*session_, configured_);
  exposures_->LookAgain(TellsExposures());
  statistics_.NumbersRestart();
  first_of_stream_ = true;
  CallOrThrow(uri_, "start of acquisition", arv_camera_start_acquisition, session_->Camera());
}

void AravisDevice::Lose(const std::string& problem) {
  events_.Say(DeviceEventKind::kFaulted, problem);
  DescribeLoss(problem);
  state_ = DeviceState::kLost;
  queue_->Close();
}

void AravisDevice::Take(ArvBuffer* buffer) {
  const ArvBufferStatus status = arv_buffer_get_status(buffer);
  if (status == ARV_BUFFER_STATUS_CLEARED || status == ARV_BUFFER_STATUS_ABORTED)
    return;  // stopping, not a loss
  one_was_whole_ |= status == ARV_BUFFER_STATUS_SUCCESS;
  if (!one_was_whole_) ++broken_;
  if (settled_at_) return CountSettling(buffer, status);
  // The library enlarges its receive buffer only when the first packet arrives. A large first frame may have
  // lost packets by then.
  if (std::exchange(first_of_stream_, false) && status != ARV_BUFFER_STATUS_SUCCESS) {
    events_.Notice("the first frame of the stream came with pixels missing");
    statistics_.Incomplete();
    return;
  }
  trigger_out_ = false;
  frames_->SetSharedClock(clock_of_camera_->IsShared());
  Frame frame = frames_->Read(buffer);
  for (std::string& note : frames_->TakeNotes()) events_.Notice(std::move(note));
  if (frame.status == FrameStatus::kIncomplete)
    ExplainLossOnce(frame.id, status);
  else
    exposures_->Label(frame);
  for (std::string& note : exposures_->TakeNotes()) events_.Notice(std::move(note));
  CountId(buffer, frame.status);
  if (status == ARV_BUFFER_STATUS_WRONG_PACKET_ID) {
    const MutexLock lock(mutex_);
    ++wrong_packet_ids_;
  }
  if (frame.status == FrameStatus::kIncomplete)
    statistics_.Incomplete();
  else if (frame.device_time_s != frame.host_time_s)
    statistics_.Timed(frame.device_time_s, frame.host_time_s, configured_.period_s);
  std::optional<Frame> dropped;
  queue_->Push(std::move(frame), &dropped);
  if (dropped && dropped->status == FrameStatus::kComplete) statistics_.Dropped();
}

// Gaps and incomplete frames count also while automatics settle.
void AravisDevice::CountSettling(ArvBuffer* buffer, ArvBufferStatus status) {
  first_of_stream_ = false;
  const bool complete = status == ARV_BUFFER_STATUS_SUCCESS;
  CountId(buffer, complete ? FrameStatus::kComplete : FrameStatus::kIncomplete);
  complete ? statistics_.WhileSettling() : statistics_.Incomplete();
}

void AravisDevice::CountId(ArvBuffer* buffer, FrameStatus status) {
  const std::uint64_t id = arv_buffer_get_frame_id(buffer);  // the stream's; the chunk data's may differ
  // A frame whose first packet was lost has no number: 0 in a camera that counts from 1.
  if (status == FrameStatus::kIncomplete && id == 0)
    statistics_.ArrivedWithoutId();
  else
    statistics_.Arrived(id);
}

void AravisDevice::ExplainLossOnce(std::uint64_t id, ArvBufferStatus status) {
  if (std::exchange(said_incomplete_, true)) return;
  const auto why = stream_->SocketBufferWarning();
  events_.Notice(
      fmt::format("frame {} arrived incomplete ({}); ulf counts such frames and does not use them{}", id,
                  BufferStatusText(status), why ? ". Perhaps because " + *why : ""));
}

}  // namespace

std::unique_ptr<Device> OpenAravisDevice(const DeviceUri& uri) { return std::make_unique<AravisDevice>(uri); }

}  // namespace ulf::acquisition
