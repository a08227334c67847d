#include "acquisition/gphoto2/photograph_requests.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "core/base/counted.h"
#include "core/base/host_time.h"

namespace ulf::acquisition {
namespace {

// The pause between two requests to a busy camera doubles each time. Guessed.
constexpr std::chrono::milliseconds kFirstBusyPause(25), kLongestBusyPause(800);
// Seconds. A busy camera may delay the release so long, then the request fails. The second is from release to
// announcement (long exposures, slow cards). Guessed.
constexpr double kBusyS = 10, kPhotographS = 60;

}  // namespace

PhotographRequests::PhotographRequests(GphotoCamera& camera, CameraSettings& settings,
                                       const std::function<void(const std::string&)>& notice,
                                       std::function<bool(const GphotoResult&)> gone)
    : camera_(camera),
      notice_(notice),
      gone_(std::move(gone)),
      shutter_bracket_(settings, kBusyS, notice),
      camera_bracket_(camera, settings, kBusyS, notice) {}

bool PhotographRequests::RequestPhotograph() { return !exposures_wanted_ && !still_wanted_.exchange(true); }

bool PhotographRequests::RequestExposures(const std::vector<double>& stops) {
  if (!sets_shutter_ || still_wanted_ || exposures_wanted_) return false;
  {
    const MutexLock lock(mutex_);
    exposures_asked_ = stops;
  }
  exposures_wanted_ = true;
  return true;
}

void PhotographRequests::Work() {
  if (exposures_wanted_) ReleaseNextExposure();
  if (still_wanted_) Release();
}

// One release after another: the next one when the photographs of the one before have come.
void PhotographRequests::ReleaseNextExposure() {
  if (still_wanted_) return;
  std::vector<double> stops;
  {
    const MutexLock lock(mutex_);
    stops = exposures_asked_;
  }
  if (!camera_bracket_.IsRunning() && !shutter_bracket_.IsRunning() && !camera_bracket_.Begin(stops))
    shutter_bracket_.Begin(stops);
  if (camera_bracket_.IsRunning()) {
    if (const int photographs = camera_bracket_.Next(); photographs > 0) {
      expected_ = photographs;
      still_wanted_ = true;
    }
    if (!camera_bracket_.IsRunning() && camera_bracket_.HasRefused()) shutter_bracket_.Begin(stops);
  } else if ((stops_being_taken_ = shutter_bracket_.Next())) {
    still_wanted_ = true;
  }
  exposures_wanted_ = camera_bracket_.IsRunning() || shutter_bracket_.IsRunning();
}

// A busy camera is asked again in a later round, after its events were handled.
void PhotographRequests::Release() {
  using Clock = std::chrono::steady_clock;
  if (released_at_) {
    if (SecondsSince(*released_at_) < kPhotographS) return;
    notice_(expected_ == 1
                ? fmt::format("no photograph came within {:.0f} s of its release; another can be requested",
                              kPhotographS)
                : fmt::format("{} of {} of the bracket came within {:.0f} s of its release", came_,
                              Counted(expected_, "photograph"), kPhotographS));
    return Clear();
  }
  if (!asked_since_) {
    asked_since_ = Clock::now();
    again_ = *asked_since_;
    pause_ = kFirstBusyPause;
  }
  if (Clock::now() < again_) return;
  const double host_time_s = EpochSeconds();
  const GphotoResult result = camera_.ReleaseShutter();
  const bool is_gone = !result.ok() && !result.Busy() && gone_(result);
  if (result.ok() || is_gone) {  // where the link broke before the answer the shutter may have been released
    released_at_ = Clock::now();
    released_host_s_ = host_time_s;
    said_busy_ = false;
    return;
  }
  if (result.Busy()) {
    if (!std::exchange(said_busy_, true)) notice_("the camera is busy; the photograph waits for it");
    again_ = Clock::now() + pause_;
    pause_ = std::min(2 * pause_, kLongestBusyPause);
    if (SecondsSince(*asked_since_) < kBusyS) return;
    notice_(fmt::format("the camera was busy for {:.0f} s: no photograph was taken", kBusyS));
    said_busy_ = false;
    return Clear();
  }
  if (result.CardFull())
    notice_("the card is full: no photograph was taken; change it, or use target=ram");
  else
    notice_(fmt::format("no photograph was taken: {}; focus=manual avoids refusals by the autofocus",
                        result.text));
  Clear();
}

bool PhotographRequests::IsAnsweredBy(const std::string& stem) {
  if (!IsReleased()) return false;
  if (static_cast<int>(stems_.size()) < expected_) stems_.insert(stem);
  return stems_.contains(stem);
}

void PhotographRequests::TellExposure(Frame& still, const std::optional<double>& told_s) {
  if (!IsReleased() || still.requested_s != released_host_s_) return;
  if (!camera_bracket_.IsRunning()) {
    still.asked_stops = stops_being_taken_;
    return;
  }
  still.asked_stops = camera_bracket_.StopsOf(told_s);
  if (!told_s) still.exposure_s = 0;  // the camera's setting is that of the exposure in the middle
}

void PhotographRequests::Came(double released_s) {
  if (IsReleased() && released_s == released_host_s_ && ++came_ >= expected_) Clear();
}

void PhotographRequests::Clear() {
  released_at_.reset();
  stems_.clear();
  expected_ = 1;
  came_ = 0;
  asked_since_.reset();
  stops_being_taken_.reset();
  still_wanted_ = false;
}

void PhotographRequests::GiveUpBracket(bool camera_is_gone) {
  shutter_bracket_.GiveUp(camera_is_gone);
  camera_bracket_.GiveUp(camera_is_gone);
  exposures_wanted_ = false;
}

}  // namespace ulf::acquisition
