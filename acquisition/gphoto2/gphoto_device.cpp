#include "acquisition/gphoto2/gphoto_device.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <iterator>
#include <thread>
#include <utility>

#include "acquisition/device/live_driver.h"
#include "acquisition/gphoto2/camera_settings.h"
#include "acquisition/gphoto2/camera_watch.h"
#include "acquisition/gphoto2/gphoto_camera.h"
#include "acquisition/gphoto2/gphoto_options.h"
#include "acquisition/gphoto2/photograph_downloads.h"
#include "acquisition/gphoto2/photograph_pairing.h"
#include "acquisition/gphoto2/photograph_recovery.h"
#include "acquisition/gphoto2/photograph_requests.h"
#include "core/base/error.h"
#include "core/base/host_time.h"
#include "core/base/quantile.h"
#include "core/image/files/exif.h"
#include "core/image/files/jpeg_codec.h"
#include "core/image/files/raw_file.h"

namespace ulf::acquisition {
namespace {

using std::chrono::milliseconds;
using Clock = std::chrono::steady_clock;

// All guessed: how long the camera's thread waits for its events at least (0 would not yield) and at most (a
// request must not wait longer), the pause after a call that failed at once, and the wait after a changed
// property, because several change together.
constexpr Clock::duration kLeastWait = milliseconds(1), kMostWait = milliseconds(100);
constexpr milliseconds kFailurePause(20), kPropertyPause(200);
// Seconds, all guessed: how long a raw file and its JPEG wait for each other, how long Stop() waits for a
// photograph that was requested before, the interval at which settings, battery and card are checked, how
// long live view may fail until the device stalls, the interval at which that is repeated, and the pause
// after a failed live view frame.
constexpr double kPairS = 3, kLastPhotographS = 10, kWatchEveryS = 5, kLiveViewTroubleS = 3,
                 kLiveViewRepeatS = 30, kLiveViewPauseS = 0.3;
constexpr int kFailuresInRow = 20;  // then a camera that cannot report its storage is lost; guessed

double NowS() { return std::chrono::duration<double>(Clock::now().time_since_epoch()).count(); }

milliseconds Milliseconds(double seconds) { return milliseconds(static_cast<int>(1000 * seconds)); }

class GphotoDevice : public LiveDriver {
 public:
  GphotoDevice(const DeviceUri& uri, std::shared_ptr<UnfetchedPhotographs> left)
      : left_(left ? std::move(left) : std::make_shared<UnfetchedPhotographs>()),
        options_(GphotoOptions::Of(uri)),
        uri_(uri.Text()),
        camera_(std::make_unique<GphotoCamera>(uri_, ResolveGphotoAddress(uri))),
        settings_(*camera_, uri_),
        downloads_(*camera_),
        pairing_(kPairS),
        watch_(*camera_, settings_, [this](const std::string& words) { Notice(words); }),
        recovery_(
            *camera_, *left_, [this](const std::string& words) { Notice(words); },
            [this](const GphotoResult& result) { return Gone(result); }),
        requests_(
            *camera_, settings_, [this](const std::string& words) { Notice(words); },
            [this](const GphotoResult& result) { return Gone(result); }) {
    events_.LogAs(uri_);
    info_ = DescribeGphoto(*camera_, uri_, uri.path.starts_with("ptpip:") ? "PTP/IP" : "USB");
    std::vector<ShotSetting> given;
    for (const auto& [setting, value] : options_.settings) given.push_back(setting);
    const std::vector<std::string> automatic = settings_.LockRemaining(given);
    for (const auto& [setting, value] : options_.settings) settings_.Lock(setting, value);
    target_is_memory_ = ChooseTarget(*camera_, uri_, options_.to_card);
    pairing_.ExpectFormat(settings_.Value(ShotSetting::kFormat));
    for (const std::string& words : automatic) Notice(words);
    requests_.ReadSettings();
    watch_.Begin(target_is_memory_);
  }

  ~GphotoDevice() override { Stop(); }

  bool HasLiveFrames() const override { return has_live_view_; }
  bool TakesStills() const override { return true; }

  StillRequest RequestStill() override {
    return state_ == DeviceState::kStreaming && requests_.RequestPhotograph() ? StillRequest::kAsked
                                                                              : StillRequest::kBusy;
  }
  ExposureRequests TakesExposures() const override {
    return requests_.TakesExposures() ? ExposureRequests::kSetTime : ExposureRequests::kNone;
  }
  StillRequest RequestExposures(const std::vector<double>& stops) override {
    return state_ == DeviceState::kStreaming && requests_.RequestExposures(stops) ? StillRequest::kAsked
                                                                                  : StillRequest::kBusy;
  }

  void Start() override {
    if (thread_.joinable()) return;
    if (!camera_) throw Error("{}: {}; open the device again", uri_, Info().problem);
    queue_ = std::make_unique<FrameQueue>(options_.queue);
    statistics_.Begin();
    stop_ = false;
    stopping_since_.reset();
    lost_ = false;
    requests_.Clear();
    state_ = DeviceState::kStreaming;
    thread_ = ReadingThread(
        [this] {
          Loop();
          End();
        },
        [this](const std::string& why) {
          Lose("reading from it failed: " + why);
          End();
        });
  }

  std::optional<Frame> Next(milliseconds timeout) override {
    if (!queue_) return std::nullopt;
    std::optional<Frame> frame = queue_->Pop(timeout);
    if (!frame) return std::nullopt;
    if (frame->encoded)
      frame->image = {DecodeJpeg(*frame->encoded->bytes), Transfer::kSrgb};
    else if (frame->raw && frame->status == FrameStatus::kComplete)
      frame->image = {Developed(*frame->raw), Transfer::kLinear};
    frame->status = frame->image.empty() ? FrameStatus::kIncomplete : FrameStatus::kComplete;
    if (frame->kind == FrameKind::kLive) frame->encoded.reset();  // live view is never kept
    frame->status == FrameStatus::kComplete ? statistics_.Delivered(*frame) : statistics_.Incomplete();
    return frame;
  }

  void Stop() override {
    if (!thread_.joinable()) return;
    stop_ = true;
    thread_.join();
    statistics_.End();
    queue_->Close();
    if (state_ == DeviceState::kLost) {
      camera_.reset();
      return;
    }
    if (has_live_view_ && camera_->Setting("viewfinder")) camera_->Set("viewfinder", "0");
    state_ = DeviceState::kEnded;
  }

  DeviceState State() const override {
    // The reader can still take photographs that were downloaded before the loss.
    if (state_ == DeviceState::kLost && queue_ && queue_->Size() > 0) return DeviceState::kStreaming;
    return state_;
  }

  DeviceStatistics Statistics() const override {
    DeviceStatistics statistics = statistics_.Now();
    statistics.dropped = queue_ ? queue_->Dropped() : 0;
    const MutexLock lock(mutex_);
    statistics.transport = {{TransportFigure::kPhotographs, photographs_},
                            {TransportFigure::kNotDownloaded, not_downloaded_},
                            {TransportFigure::kLiveViewRefused, live_view_refused_}};
    if (!release_to_announcement_s_.empty())
      statistics.transport.emplace_back(TransportFigure::kReleaseToAnnouncementMs,
                                        1e3 * Median(release_to_announcement_s_));
    return statistics;
  }

 private:
  void Loop() {
    const auto period = DurationOf(1 / options_.live_view_fps);
    Clock::time_point next_live = Clock::now();
    next_watch_ = Clock::now() + Milliseconds(kWatchEveryS);
    recovery_.Begin();
    while (!MayStop() && !lost_) {
      QueueLeft();
      requests_.Work();
      if (has_live_view_ && !stop_ && Clock::now() >= next_live) {
        LiveView();
        next_live = std::max(next_live + period, Clock::now());
        if (live_view_pause_s_ > 0) next_live += Milliseconds(live_view_pause_s_);
      }
      const auto free = has_live_view_ ? next_live - Clock::now() : kMostWait;
      HandleEvents(std::chrono::duration_cast<milliseconds>(std::clamp(free, kLeastWait, kMostWait)));
      if (!lost_) Download();
      Deliver(false);
      if (!lost_ && Clock::now() >= next_watch_) Watch();
      if (!lost_) OutOfStep();
    }
  }

  // Ends the thread: delivers downloaded photographs, names the others, and only then reports a loss.
  void End() {
    Deliver(true);
    requests_.GiveUpBracket(lost_);
    {
      const MutexLock lock(mutex_);
      not_downloaded_ += static_cast<double>(downloads_.Count());
    }
    std::vector<FileInCamera> files = downloads_.GiveUpAll();
    if (!files.empty())
      Notice(fmt::format(
          "not downloaded, still in the camera: {}; {}", NamesOf(files),
          lost_ ? "fetched when the camera is back, else copy from the card" : "copy from the card"));
    if (!lost_) return;
    if (requests_.IsReleased())
      Notice(
          "the requested photograph has not arrived: if it was taken, it is in the camera and fetched when "
          "that is back");
    // What stayed in the camera when the link was lost before still counts until it has been looked for.
    UnfetchedPhotographs::Unfetched left = recovery_.TakeUnfetched().value_or(
        UnfetchedPhotographs::Unfetched{.waiting = {}, .lost_s = EpochSeconds()});
    std::ranges::move(files, std::back_inserter(left.waiting));
    if (requests_.AwaitsAnnouncement()) left.released_s = requests_.ReleasedHostS();
    left_->Lost(std::move(left));
    queue_->Close();
    state_ = DeviceState::kLost;
  }

  void QueueLeft() {
    auto found = recovery_.Work();
    if (!found) return;
    {
      // They were counted when the link dropped.
      const MutexLock lock(mutex_);
      not_downloaded_ -= static_cast<double>(found->counted);
    }
    for (const GphotoFile& file : found->since)
      if (!IsInCameraMemory(file.folder, target_is_memory_)) left_->Fetched(file);
    for (auto& [where, file] : found->files) downloads_.Announced(where, std::move(file), NowS());
  }

  // Returns whether the thread is to stop and no photograph is still expected.
  bool MayStop() {
    if (!stop_) return false;
    if (!requests_.IsReleased() && downloads_.Count() == 0) return true;
    if (!stopping_since_) stopping_since_ = Clock::now();
    return SecondsSince(*stopping_since_) > kLastPhotographS;
  }

  void LiveView() {
    std::string jpeg;
    const GphotoResult result = camera_->LiveView(jpeg);
    const double host_time_s = EpochSeconds();
    if (result.ok() && !jpeg.empty()) {
      live_view_trouble_since_.reset();
      live_view_pause_s_ = 0;
      Frame frame;
      frame.id = ++next_id_;
      frame.device_time_s = frame.host_time_s = host_time_s;
      frame.encoded = EncodedImage{".jpg", std::make_shared<const std::string>(std::move(jpeg))};
      queue_->Push(std::move(frame));
      return;
    }
    {
      const MutexLock lock(mutex_);
      ++live_view_refused_;
    }
    if (result.NotSupported()) {
      has_live_view_ = false;
      Notice("this camera's driver has no live view: it takes photographs only, and ulf cannot track it");
      return;
    }
    if (result.Busy() || requests_.IsReleased()) return;  // the mirror is up
    if (!result.ok() && Gone(result)) return;
    // Some cameras refuse live view for a moment after a photograph; only a longer refusal is reported.
    if (!live_view_trouble_since_) live_view_trouble_since_ = Clock::now();
    live_view_pause_s_ = kLiveViewPauseS;
    if (SecondsSince(*live_view_trouble_since_) < kLiveViewTroubleS) return;
    live_view_trouble_since_ = Clock::now() + Milliseconds(kLiveViewRepeatS);
    events_.Say(
        DeviceEventKind::kStalled,
        fmt::format("no live view: {}; check the camera's display, its mode dial and its lens", result.text));
  }

  // Handles all events of the camera; waits up to `timeout` for the first.
  void HandleEvents(milliseconds timeout) {
    while (!lost_) {
      GphotoEvent event;
      const GphotoResult result = camera_->WaitForEvent(static_cast<int>(timeout.count()), event);
      if (OutOfStep()) return;
      if (!result.ok()) {
        if (result.Busy() || result.NotSupported()) return;
        if (!Gone(result)) std::this_thread::sleep_for(kFailurePause);  // the call may fail without waiting
        return;
      }
      failures_ = 0;
      if (event.kind == GphotoEventKind::kNothing) return;
      if (event.kind == GphotoEventKind::kFileAdded) QueueDownload(event.file);
      // A property has changed, perhaps one of those that are watched.
      if (event.kind == GphotoEventKind::kOther && event.text.find("ropert") != std::string::npos)
        next_watch_ = std::min(next_watch_, Clock::now() + kPropertyPause);
      timeout = milliseconds(1);
    }
  }

  void QueueDownload(const GphotoFile& announced) {
    // An event that the camera had kept. Names in its memory come again for other photographs.
    if (!IsInCameraMemory(announced.folder, target_is_memory_) && left_->WasFetched(announced)) return;
    left_->Announced(announced);
    DownloadedFile file;
    file.name = announced.name;
    file.announced_s = EpochSeconds();
    if (auto late = pairing_.LateFile(announced.name, NowS())) {
      file = std::move(*late);  // of an earlier photograph, so it answers no later request
    } else {
      const bool is_first = requests_.AwaitsAnnouncement();
      if (requests_.IsAnsweredBy(StemOf(announced.name))) file.released_s = requests_.ReleasedHostS();
      if (is_first) {
        const MutexLock lock(mutex_);
        release_to_announcement_s_.push_back(file.announced_s - file.released_s);
      }
    }
    downloads_.Announced(announced, std::move(file), NowS());
    Download();
  }

  void Download() {
    PhotographDownloads::Outcome outcome = downloads_.Work(NowS());
    for (auto& [where, file] : outcome.downloaded) {
      if (IsInCameraMemory(where.folder, target_is_memory_)) camera_->Delete(where);
      pairing_.Add(std::move(file), NowS());
    }
    for (const std::string& message : outcome.messages) Notice(message);
    for (const DownloadedFile& file : outcome.given_up) {
      // The other file of this photograph may answer the request.
      const std::string stem = StemOf(file.name);
      if (!downloads_.Awaits(stem) && !pairing_.Holds(stem)) requests_.Came(file.released_s);
      const MutexLock lock(mutex_);
      ++not_downloaded_;
    }
    if (!outcome.failure.ok()) Gone(outcome.failure);
  }

  void Deliver(bool all) {
    const auto on_its_way = [this](const std::string& stem) { return downloads_.Awaits(stem); };
    for (DownloadedPhotograph& photograph : all ? pairing_.TakeAll() : pairing_.Take(NowS(), on_its_way)) {
      const std::string name = photograph.First().name;
      const bool is_late = photograph.First().is_late;
      const ExifFacts exif = ExifOf(photograph);
      Frame frame = FrameOf(std::move(photograph), exif, settings_, options_.shutter_lag_s);
      frame.id = ++next_id_;
      frame.host_time_s = EpochSeconds();
      if (exif.orientation != 1 && !std::exchange(said_turned_, true))
        Notice(
            "photographs are marked to be turned when they are shown: other programs turn them, ulf does "
            "not; switch the camera's automatic rotation off");
      if (is_late) {
        Notice(fmt::format("{} came long after its photograph's other file: ulf keeps it by itself", name));
        // The photograph was delivered as its JPEG: the same once more would be no view.
        if (!frame.encoded) frame.status = FrameStatus::kIncomplete;
      }
      {
        const MutexLock lock(mutex_);
        if (!is_late) ++photographs_;
      }
      requests_.TellExposure(frame, exif.exposure_s);
      requests_.Came(frame.requested_s.value_or(0));
      queue_->Push(std::move(frame));
    }
  }

  static ExifFacts ExifOf(const DownloadedPhotograph& photograph) {
    if (!photograph.jpeg.bytes.empty()) return ReadExif(photograph.jpeg.bytes);
    try {
      return RawFactsOf(photograph.raw.bytes, photograph.raw.name).exif;
    } catch (const Error&) {
      return {};  // whoever develops it says why
    }
  }

  // It is empty where it cannot be developed, with a notice.
  cv::Mat Developed(const EncodedImage& raw) {
    try {
      return DecodeRaw(*raw.bytes, fmt::format("the photograph ({})", raw.extension), RawQuality::kQuick)
          .light;
    } catch (const Error& error) {
      Notice(error.what());
      return {};
    }
  }

  void Watch() {
    next_watch_ = Clock::now() + Milliseconds(kWatchEveryS);
    const GphotoResult result = watch_.Poll();
    pairing_.ExpectFormat(settings_.Value(ShotSetting::kFormat));
    if (!result.ok()) Gone(result);
  }

  // Returns whether the camera is disconnected; where the error code does not tell, asks for its storage.
  bool Gone(const GphotoResult& result) {
    if (OutOfStep()) return true;
    bool gone = result.LinkIsGone();
    if (!gone && watch_.HasStorage()) {
      std::vector<GphotoStorage> ignored;
      const GphotoResult life = camera_->Storages(ignored);
      gone = !life.ok() && !life.Busy();
    }
    if (!gone && !watch_.HasStorage()) gone = ++failures_ >= kFailuresInRow;
    if (gone)
      Lose(
          fmt::format("the camera no longer answers ({}); check its cable or network, its switch and its "
                      "battery",
                      result.text));
    return gone;
  }

  bool OutOfStep() {
    if (camera_->OutOfStep())
      Lose("an answer of the camera came too late; its connection must be opened again");
    return lost_;
  }

  void Lose(const std::string& problem) {
    DescribeLoss(problem);
    requests_.ReleaseNoMore();
    lost_ = true;
  }

  void Notice(const std::string& text) { events_.Notice(text); }

  const std::shared_ptr<UnfetchedPhotographs> left_;
  const GphotoOptions options_;
  const std::string uri_;
  std::unique_ptr<GphotoCamera> camera_;
  CameraSettings settings_;
  PhotographDownloads downloads_;
  PhotographPairing pairing_;
  CameraWatch watch_;
  PhotographRecovery recovery_;
  PhotographRequests requests_;

  // Used by the camera's thread.
  bool target_is_memory_ = false;
  bool lost_ = false;
  bool said_turned_ = false;
  std::optional<Clock::time_point> stopping_since_, live_view_trouble_since_;
  double live_view_pause_s_ = 0;
  Clock::time_point next_watch_;
  std::uint64_t next_id_ = 0;
  int failures_ = 0;

  // Shared.
  std::atomic<bool> stop_{false}, has_live_view_{true};
  double photographs_ ULF_GUARDED_BY(mutex_) = 0;
  double live_view_refused_ ULF_GUARDED_BY(mutex_) = 0;
  double not_downloaded_ ULF_GUARDED_BY(mutex_) = 0;
  std::vector<double> release_to_announcement_s_ ULF_GUARDED_BY(mutex_);
};

}  // namespace

std::unique_ptr<Device> OpenGphotoDevice(const DeviceUri& uri, std::shared_ptr<UnfetchedPhotographs> left) {
  return std::make_unique<GphotoDevice>(uri, std::move(left));
}

std::vector<DeviceInfo> ListGphotoDevices() {
  std::vector<DeviceInfo> devices;
  for (const GphotoAddress& camera : DetectGphotoCameras()) {
    DeviceInfo info{.uri = "gphoto2:" + camera.port,
                    .maker = {},
                    .model = camera.model,
                    .serial = {},
                    .bus = "USB",
                    .problem = UsbObstacle(camera.port)};
    info.available = info.problem.empty();
    devices.push_back(info);
  }
  return devices;
}

}  // namespace ulf::acquisition
