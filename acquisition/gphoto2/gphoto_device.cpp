#include "acquisition/gphoto2/gphoto_device.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <mutex>
#include <thread>
#include <utility>

#include "acquisition/error.h"
#include "acquisition/gphoto2/camera_settings.h"
#include "acquisition/gphoto2/gphoto_camera.h"
#include "acquisition/gphoto2/gphoto_options.h"
#include "acquisition/gphoto2/jpeg_file.h"
#include "acquisition/gphoto2/photograph_inbox.h"
#include "acquisition/gphoto2/photograph_pairing.h"

namespace ulf {
namespace {

using std::chrono::milliseconds;
using Clock = std::chrono::steady_clock;

constexpr double kPairPatienceS = 3;   // a raw file and its JPEG
constexpr double kBusyPatienceS = 10;  // of a release that the camera puts off
constexpr double kPhotographPatienceS =
    60;  // from the release to the announcement: long exposures, slow cards
constexpr double kLastPhotographPatienceS = 10;  // of one that was asked for before the end
constexpr double kWatchEveryS = 5;               // settings, battery, card
constexpr int kBatteryLow = 15;                  // percent

double HostNow() {
  return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
}
double Seconds(Clock::duration duration) { return std::chrono::duration<double>(duration).count(); }

// The camera's own memory, which forgets: there the file is taken away after its download. Never from a card.
bool IsInCameraMemory(const std::string& folder, bool target_is_memory) {
  return target_is_memory && !folder.starts_with("/store_");
}

class GphotoDevice : public Device {
 public:
  explicit GphotoDevice(const DeviceUri& uri)
      : options_(GphotoOptions::Of(uri)),
        uri_(uri.Text()),
        camera_(std::make_unique<GphotoCamera>(uri_, ResolveGphotoAddress(uri))),
        settings_(*camera_, uri_),
        pairing_(kPairPatienceS) {
    const auto text = [&](const char* name) {
      const auto setting = camera_->Setting(name);
      return setting ? setting->value : std::string();
    };
    info_ = {.uri = uri_,
             .maker = text("manufacturer"),
             .model = text("cameramodel"),
             .serial = text("serialnumber"),
             .bus = uri.path.starts_with("ptpip:") ? "PTP/IP" : "USB",
             .problem = {}};
    std::vector<ShotSetting> given;
    for (const auto& [setting, value] : options_.settings) given.push_back(setting);
    const std::vector<std::string> automatic = settings_.LockTheRest(given);
    for (const auto& [setting, value] : options_.settings) settings_.Lock(setting, value);
    ChooseTarget();
    pairing_.ExpectFormat(settings_.Value(ShotSetting::kFormat));
    for (const std::string& words : automatic) Notice(words);
    NoticeRawOnly();
    watches_storage_ = camera_->Storages(storages_).ok();
    WatchBatteryAndCard();
  }

  ~GphotoDevice() override { Stop(); }

  DeviceInfo Info() const override {
    const std::lock_guard lock(mutex_);
    return info_;
  }
  bool IsLive() const override { return true; }
  bool TakesStills() const override { return true; }

  StillRequest RequestStill() override {
    if (state_ != DeviceState::kStreaming || still_wanted_.exchange(true)) return StillRequest::kBusy;
    return StillRequest::kAsked;
  }

  void Start() override {
    if (thread_.joinable()) return;
    if (!camera_) throw Error("{}: {}; open the device again", uri_, Info().problem);
    inbox_ = std::make_unique<PhotographInbox>(options_.queue);
    {
      const std::lock_guard lock(mutex_);
      statistics_ = {};
    }
    started_ = Clock::now();
    stop_ = false;
    stopping_since_.reset();
    DoneWithStill();
    state_ = DeviceState::kStreaming;
    thread_ = std::thread([this] {
      try {
        Loop();
      } catch (const std::exception& error) {
        Lose(fmt::format("reading from it failed: {}", error.what()));
        inbox_->Close();
      }
    });
  }

  std::optional<Frame> Next(milliseconds timeout) override {
    if (!inbox_) return std::nullopt;
    std::optional<Frame> frame = inbox_->Pop(timeout);
    if (!frame) return std::nullopt;
    if (frame->encoded) frame->image = {DecodeJpeg(*frame->encoded->bytes), Transfer::kSrgb};
    frame->status = frame->image.empty() ? FrameStatus::kIncomplete : FrameStatus::kComplete;
    if (frame->kind == FrameKind::kLive) frame->encoded.reset();  // live view is never kept
    const std::lock_guard lock(mutex_);
    ++(frame->status == FrameStatus::kComplete ? statistics_.delivered : statistics_.incomplete);
    statistics_.bytes += frame->image.pixels.total() * frame->image.pixels.elemSize();
    return frame;
  }

  void Stop() override {
    if (!thread_.joinable()) return;
    stop_ = true;
    thread_.join();
    inbox_->Close();
    if (state_ == DeviceState::kLost) {
      camera_.reset();
      return;
    }
    if (has_live_view_ && camera_->Setting("viewfinder")) camera_->Set("viewfinder", "0");
    state_ = DeviceState::kEnded;
  }

  DeviceState State() const override {
    // What was downloaded before the cable came off is still to be taken.
    if (state_ == DeviceState::kLost && inbox_ && !inbox_->IsEmpty()) return DeviceState::kStreaming;
    return state_;
  }

  DeviceStatistics Statistics() const override {
    const std::lock_guard lock(mutex_);
    DeviceStatistics statistics = statistics_;
    statistics.dropped = inbox_ ? inbox_->Dropped() : 0;
    statistics.seconds = started_ ? Seconds(Clock::now() - *started_) : 0;
    statistics.transport = {{"photographs", photographs_}, {"live view refused", live_view_refused_}};
    return statistics;
  }

  std::vector<DeviceEvent> TakeEvents() override {
    const std::lock_guard lock(mutex_);
    return std::exchange(events_, {});
  }

 private:
  // ---- Before streaming: the thread that opens; then the camera's thread alone. ----

  void ChooseTarget() {
    const auto target = camera_->Setting("capturetarget");
    if (!target) return;
    const auto choice = [&](const char* word) -> std::optional<std::string> {
      for (const std::string& offered : target->choices)
        if (offered.find(word) != std::string::npos) return offered;
      return std::nullopt;
    };
    const auto card = choice("card"), ram = choice("RAM");
    bool to_card = options_.to_card.value_or(false);
    if (!options_.to_card && camera_->Storages(storages_).ok())
      to_card = std::any_of(storages_.begin(), storages_.end(),
                            [](const GphotoStorage& storage) { return storage.is_card && !storage.is_full; });
    const auto wanted = to_card ? card : ram;
    if (options_.to_card && !wanted)
      throw UsageError("{}: target={} is not offered by this camera; leave it out", uri_,
                       to_card ? "card" : "ram");
    if (wanted && target->value != *wanted) {
      const GphotoResult result = camera_->Set("capturetarget", *wanted);
      if (!result.ok() && options_.to_card)
        throw Error("{}: the target cannot be set ({}); leave out target=", uri_, result.text);
    }
    const auto now = camera_->Setting("capturetarget");
    target_is_memory_ = now && now->value.find("RAM") != std::string::npos;
  }

  void Loop() {
    const auto period = std::chrono::duration_cast<Clock::duration>(
        std::chrono::duration<double>(1 / options_.live_view_fps));
    Clock::time_point next_live = Clock::now();
    next_watch_ = Clock::now() + milliseconds(static_cast<int>(1000 * kWatchEveryS));
    while (!MayStop() && state_ != DeviceState::kLost) {
      if (still_wanted_) Release();
      if (has_live_view_ && !stop_ && Clock::now() >= next_live) {
        LiveView();
        next_live = std::max(next_live + period, Clock::now());
        if (live_view_pause_s_ > 0) next_live += milliseconds(static_cast<int>(1000 * live_view_pause_s_));
      }
      const auto free = has_live_view_ ? next_live - Clock::now() : Clock::duration(milliseconds(100));
      constexpr Clock::duration kLeast = milliseconds(1), kMost = milliseconds(100);
      Drain(static_cast<int>(
          std::chrono::duration_cast<milliseconds>(std::clamp(free, kLeast, kMost)).count()));
      Deliver(false);
      if (Clock::now() >= next_watch_) Watch();
    }
    Deliver(true);
    if (state_ == DeviceState::kLost) inbox_->Close();
  }

  // Told to stop, with no photograph on its way any more.
  bool MayStop() {
    if (!stop_) return false;
    if (!released_at_) return true;
    if (!stopping_since_) stopping_since_ = Clock::now();
    return Seconds(Clock::now() - *stopping_since_) > kLastPhotographPatienceS;
  }

  // Asks for a photograph; a busy camera is asked again on the next round, with its events taken meanwhile.
  void Release() {
    if (released_at_) {
      if (Seconds(Clock::now() - *released_at_) < kPhotographPatienceS) return;
      Notice(fmt::format("no photograph came within {:.0f} s of its release; asking again is possible",
                         kPhotographPatienceS));
      return DoneWithStill();
    }
    if (!asked_since_) asked_since_ = Clock::now();
    const double host_time_s = HostNow();
    const GphotoResult result = camera_->ReleaseShutter();
    if (result.ok()) {
      released_at_ = Clock::now();
      released_host_s_ = host_time_s;
      said_busy_ = false;
      return;
    }
    if (result.Busy()) {
      if (!std::exchange(said_busy_, true)) Notice("the camera is busy; the photograph waits for it");
      if (Seconds(Clock::now() - *asked_since_) < kBusyPatienceS) return;
      Notice(fmt::format("the camera was busy for {:.0f} s: no photograph was taken", kBusyPatienceS));
      said_busy_ = false;
      return DoneWithStill();
    }
    if (Gone(result)) return;
    if (result.CardFull())
      Notice("the card is full: no photograph was taken; change it, or use target=ram");
    else
      Notice(fmt::format("no photograph was taken: {}; focus=manual avoids refusals by the autofocus",
                         result.text));
    DoneWithStill();
  }

  void DoneWithStill() {
    released_at_.reset();
    asked_since_.reset();
    still_wanted_ = false;
  }

  void LiveView() {
    std::string jpeg;
    const GphotoResult result = camera_->LiveView(jpeg);
    const double host_time_s = HostNow();
    if (result.ok() && !jpeg.empty()) {
      live_view_trouble_since_.reset();
      live_view_pause_s_ = 0;
      Frame frame;
      frame.id = ++next_id_;
      frame.device_time_s = frame.host_time_s = host_time_s;
      frame.encoded = EncodedImage{".jpg", std::make_shared<const std::string>(std::move(jpeg))};
      inbox_->PushLive(std::move(frame));
      return;
    }
    {
      const std::lock_guard lock(mutex_);
      ++live_view_refused_;
    }
    if (result.NotSupported()) {
      has_live_view_ = false;
      Notice("this camera gives no live view over its driver: photographs only, nothing to track by");
      return;
    }
    if (result.Busy() || released_at_) return;  // the mirror is up
    if (!result.ok() && Gone(result)) return;
    // Some refuse for a moment after a photograph; a camera that goes on refusing says why.
    constexpr double kToldAfterS = 3, kPauseS = 0.3;
    if (!live_view_trouble_since_) live_view_trouble_since_ = Clock::now();
    live_view_pause_s_ = kPauseS;
    if (Seconds(Clock::now() - *live_view_trouble_since_) < kToldAfterS) return;
    live_view_trouble_since_ = Clock::now() + std::chrono::seconds(30);
    Event(DeviceEventKind::kStalled,
          fmt::format("no live view: {}; look at the camera's display, its mode dial and its lens",
                      result.text));
  }

  // Everything that the camera has to say, waiting no longer than this for the first word.
  void Drain(int timeout_ms) {
    while (state_ != DeviceState::kLost) {
      GphotoEvent event;
      const GphotoResult result = camera_->WaitForEvent(timeout_ms, event);
      if (!result.ok()) {
        if (result.Busy() || result.NotSupported()) return;
        if (!Gone(result))
          std::this_thread::sleep_for(milliseconds(20));  // it may return at once, again and again
        return;
      }
      failures_ = 0;
      if (event.kind == GphotoEventKind::kNothing) return;
      if (event.kind == GphotoEventKind::kFileAdded) Fetch(event.file);
      // A property has changed: it may be one of ours.
      if (event.kind == GphotoEventKind::kOther && event.text.find("ropert") != std::string::npos)
        next_watch_ = std::min(next_watch_, Clock::now() + milliseconds(200));
      timeout_ms = 1;
    }
  }

  void Fetch(const GphotoFile& announced) {
    DownloadedFile file;
    file.name = announced.name;
    file.announced_s = HostNow();
    file.released_s = released_at_ ? released_host_s_ : 0;
    const auto began = Clock::now();
    GphotoResult result;
    constexpr int kTries = 5;
    for (int i = 0; i < kTries; ++i) {
      result = camera_->Download(announced, file.bytes);
      if (!result.Busy()) break;
      std::this_thread::sleep_for(milliseconds(100));
    }
    if (!result.ok()) {
      Notice(fmt::format("{}/{} could not be downloaded ({}); it is still in the camera", announced.folder,
                         announced.name, result.text));
      Gone(result);
      return;
    }
    spdlog::debug("{}: {}/{}, {} bytes in {:.3f} s", uri_, announced.folder, announced.name,
                  file.bytes.size(), Seconds(Clock::now() - began));
    if (IsInCameraMemory(announced.folder, target_is_memory_)) camera_->Delete(announced);
    pairing_.Add(std::move(file), Seconds(Clock::now().time_since_epoch()));
  }

  void Deliver(bool all) {
    for (DownloadedPhotograph& photograph : pairing_.Take(Seconds(Clock::now().time_since_epoch()), all)) {
      Frame frame;
      frame.kind = FrameKind::kStill;
      frame.id = ++next_id_;
      const DownloadedFile& first = photograph.First();
      const bool asked = first.released_s > 0;
      frame.device_time_s = asked ? first.released_s + options_.shutter_lag_s : first.announced_s;
      frame.host_time_s = HostNow();
      const ExifFacts exif = ReadExif(photograph.jpeg.bytes);
      frame.exposure_s = exif.exposure_s.value_or(settings_.Number(ShotSetting::kShutter).value_or(0));
      frame.gain = exif.iso.value_or(settings_.Number(ShotSetting::kIso).value_or(100)) / 100;
      frame.f_number = exif.f_number ? exif.f_number : settings_.Number(ShotSetting::kAperture);
      if (exif.orientation != 1 && !std::exchange(said_turned_, true))
        Notice(
            "photographs carry a note that they are to be turned: it is not followed here, but other "
            "programs "
            "will; switch the camera's automatic rotation off");
      if (!photograph.jpeg.bytes.empty())
        frame.encoded =
            EncodedImage{".jpg", std::make_shared<const std::string>(std::move(photograph.jpeg.bytes))};
      if (!photograph.raw.bytes.empty())
        frame.raw = EncodedImage{ExtensionOf(photograph.raw.name),
                                 std::make_shared<const std::string>(std::move(photograph.raw.bytes))};
      if (!frame.encoded)
        Notice(
            fmt::format("{} has no JPEG beside it: it is kept, but raw is not decoded here; set the image "
                        "format to one with JPEG (imageformat=)",
                        photograph.raw.name));
      {
        const std::lock_guard lock(mutex_);
        ++photographs_;
      }
      inbox_->PushStill(std::move(frame));
      if (asked) DoneWithStill();
    }
  }

  // Slow things: settings that the camera or a hand has changed, battery, card.
  void Watch() {
    next_watch_ = Clock::now() + milliseconds(static_cast<int>(1000 * kWatchEveryS));
    for (const std::string& change : settings_.Changes()) Notice(change);
    pairing_.ExpectFormat(settings_.Value(ShotSetting::kFormat));
    NoticeRawOnly();
    if (watches_storage_) {
      const GphotoResult result = camera_->Storages(storages_);
      if (!result.ok() && !result.Busy() && Gone(result)) return;
    }
    WatchBatteryAndCard();
  }

  void NoticeRawOnly() {
    const std::string format = settings_.Value(ShotSetting::kFormat);
    PhotographPairing asks(0);
    asks.ExpectFormat(format);
    if (asks.ExpectsJpeg() || std::exchange(said_raw_only_, true)) return;
    const auto names = {"imageformat", "imagequality"};
    std::string with_jpeg;
    for (const char* name : names)
      if (const auto setting = camera_->Setting(name)) {
        for (const std::string& choice : setting->choices) {
          asks.ExpectFormat(choice);
          if (asks.ExpectsJpeg()) with_jpeg += (with_jpeg.empty() ? "" : ", ") + choice;
        }
        break;
      }
    Notice(fmt::format(
        "the image format is '{}': its photographs are kept in unposed/ but cannot be used, raw is "
        "not decoded here; set imageformat= to one of {}",
        format, with_jpeg));
  }

  void WatchBatteryAndCard() {
    if (const auto battery = camera_->Setting("batterylevel")) {
      const int percent = std::atoi(battery->value.c_str());
      const bool low = battery->value.find('%') != std::string::npos ? percent <= kBatteryLow
                                                                     : battery->value.starts_with("Low");
      if (low && !said_battery_)
        Notice(fmt::format("the battery is low ({}); have another ready", battery->value));
      said_battery_ = low;
    }
    const bool full =
        !target_is_memory_ &&
        std::any_of(storages_.begin(), storages_.end(), [](const GphotoStorage& s) { return s.is_card; }) &&
        std::all_of(storages_.begin(), storages_.end(), [](const GphotoStorage& s) { return s.is_full; });
    if (full && !said_full_) Notice("the card is full; change it, or use target=ram");
    said_full_ = full;
  }

  // Whether the camera is out of reach after this failure; asks it for a sign of life where the code alone
  // does not tell.
  bool Gone(const GphotoResult& result) {
    bool gone = result.LinkIsGone();
    if (!gone && watches_storage_) {
      std::vector<GphotoStorage> ignored;
      const GphotoResult life = camera_->Storages(ignored);
      gone = !life.ok() && !life.Busy();
    }
    constexpr int kFailuresInARow = 20;  // of a camera that cannot be asked
    if (!gone && !watches_storage_) gone = ++failures_ >= kFailuresInARow;
    if (gone)
      Lose(
          fmt::format("the camera no longer answers ({}); check its cable or network, that it is on and its "
                      "battery charged",
                      result.text));
    return gone;
  }

  void Lose(const std::string& problem) {
    {
      const std::lock_guard lock(mutex_);
      info_.available = false;
      info_.problem = problem;
    }
    still_wanted_ = false;
    state_ = DeviceState::kLost;
  }

  void Notice(const std::string& text) { Event(DeviceEventKind::kNotice, text); }
  void Event(DeviceEventKind kind, const std::string& text) {
    spdlog::debug("{}: {}", uri_, text);
    const std::lock_guard lock(mutex_);
    events_.push_back({kind, HostNow(), text});
  }

  const GphotoOptions options_;
  const std::string uri_;
  std::unique_ptr<GphotoCamera> camera_;
  CameraSettings settings_;
  PhotographPairing pairing_;

  // The camera's thread.
  std::vector<GphotoStorage> storages_;
  bool target_is_memory_ = false;
  bool watches_storage_ = false;
  bool said_busy_ = false, said_battery_ = false, said_full_ = false, said_raw_only_ = false,
       said_turned_ = false;
  std::optional<Clock::time_point> asked_since_, released_at_, stopping_since_, live_view_trouble_since_;
  double released_host_s_ = 0;
  double live_view_pause_s_ = 0;
  Clock::time_point next_watch_;
  std::uint64_t next_id_ = 0;
  int failures_ = 0;

  // Shared.
  std::atomic<bool> stop_{false}, still_wanted_{false}, has_live_view_{true};
  std::atomic<DeviceState> state_{DeviceState::kConnected};
  std::unique_ptr<PhotographInbox> inbox_;
  mutable std::mutex mutex_;
  DeviceInfo info_;
  DeviceStatistics statistics_;
  std::vector<DeviceEvent> events_;
  std::optional<Clock::time_point> started_;
  double photographs_ = 0, live_view_refused_ = 0;
  std::thread thread_;
};

}  // namespace

std::unique_ptr<Device> OpenGphotoDevice(const DeviceUri& uri) { return std::make_unique<GphotoDevice>(uri); }

}  // namespace ulf
