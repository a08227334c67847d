#include "acquisition/simulator/simulated_device.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <map>
#include <thread>

#include "acquisition/device/frame_id_counter.h"
#include "acquisition/simulator/scene/noise.h"
#include "acquisition/simulator/scene/scene.h"
#include "acquisition/simulator/simulated_board.h"
#include "acquisition/simulator/simulated_camera.h"
#include "acquisition/simulator/simulated_chart.h"
#include "core/base/error.h"
#include "core/base/host_time.h"
#include "core/base/mutex.h"

namespace ulf::acquisition {
namespace {

using Clock = std::chrono::steady_clock;

// A simulated camera that is unplugged.
struct Absence {
  Clock::time_point back;
  std::uint64_t next_frame = 0;
};
// The disconnected cameras by URI. They outlive their device, which is closed meanwhile.
Mutex absences_mutex;
std::map<std::string, Absence> absences ULF_GUARDED_BY(absences_mutex);

void BeginAbsence(const std::string& uri, const Absence& absence) {
  const MutexLock lock(absences_mutex);
  absences[uri] = absence;
}

// Returns the number of the next frame. Throws Error while the camera is unplugged.
std::uint64_t EndAbsence(const std::string& uri) {
  const MutexLock lock(absences_mutex);
  const auto found = absences.find(uri);
  if (found == absences.end()) return 0;
  const double left_s = std::chrono::duration<double>(found->second.back - Clock::now()).count();
  if (left_s > 0)
    throw Error("{}: the simulated cable is unplugged; it is plugged in again in {:.1f} s", uri, left_s);
  const std::uint64_t next_frame = found->second.next_frame;
  absences.erase(found);
  return next_frame;
}

class SimulatedDevice : public Device {
 public:
  SimulatedDevice(const DeviceUri& uri, std::shared_ptr<const HandMotion> hand)
      : uri_(uri),
        camera_(SimulationOptions::FromUri(uri), std::move(hand)),
        faults_(camera_.options().faults) {
    const GigeLinkFaults& link = faults_.link;
    if (link.lost > 0 || link.doubled > 0 || link.swapped > 0 || link.late > 0 || !faults_.resends ||
        !faults_.masters_lost.empty())
      throw Refused(uri.Text(), "lost, doubled, swapped, late, resend and ptp_lost are faults of a network",
                    "serve the camera on one with 'ulf simulate --fault ...' and open it by aravis:");
    next_ = EndAbsence(uri.Text());
  }

  DeviceInfo Info() const override {
    return {.uri = uri_.Text(),
            .maker = "ULF",
            .model = "simulated hand-held camera",
            .serial = "sim-" + camera_.options().scene + "-" + std::to_string(camera_.options().seed),
            .bus = "simulated",
            .available = !lost_,
            .problem = lost_ ? "the simulated cable is unplugged" : ""};
  }
  std::optional<CameraModel> Camera() const override { return camera_.StoredCamera(); }
  bool IsLive() const override { return false; }
  std::optional<SensorWindow> Window() const override {
    const int width = camera_.options().width, height = camera_.options().height;
    return SensorWindow{
        .sensor_width = width, .sensor_height = height, .x = 0, .y = 0, .width = width, .height = height};
  }
  // The switch of a lens's own automatic focus is one that the camera does not know.
  HeldAutomatics Held() const override {
    HeldAutomatics held{.exposure = true, .white_balance = true, .focus = true};
    if (faults_.auto_exposure == AutoExposure::kTold) held.exposure = false;
    if (faults_.auto_exposure == AutoExposure::kUntold) held.exposure.reset();
    if (faults_.hunting.radius_px > 0) held.focus.reset();
    return held;
  }
  ExposureRequests TakesExposures() const override { return ExposureRequests::kSequencer; }
  StillRequest RequestExposures(const std::vector<double>& stops) override {
    if (!stops_to_come_.empty()) return StillRequest::kBusy;
    stops_to_come_.assign(stops.begin(), stops.end());
    return StillRequest::kAsked;
  }
  void Start() override { started_ = true; }
  void Stop() override { started_ = false; }

  std::optional<Frame> Next(std::chrono::milliseconds timeout) override {
    if (State() != DeviceState::kStreaming) return std::nullopt;
    if (const FaultSpan* out = ActiveSpan(faults_.disconnects)) {
      lost_ = true;
      BeginAbsence(uri_.Text(), {Clock::now() + DurationOf(out->for_s), FrameAfter(*out)});
      return std::nullopt;
    }
    if (const FaultSpan* frozen = ActiveSpan(faults_.freezes))
      if (!WaitForEnd(*frozen, timeout)) return std::nullopt;
    return CaptureNext();
  }

  DeviceState State() const override {
    if (lost_) return DeviceState::kLost;
    if (!started_) return DeviceState::kConnected;
    const bool over = Now() >= camera_.options().duration_s;
    return over ? DeviceState::kEnded : DeviceState::kStreaming;
  }
  DeviceStatistics Statistics() const override {
    DeviceStatistics statistics = statistics_;
    statistics.missing = ids_.Missing();
    return statistics;
  }

 private:
  double Now() const { return static_cast<double>(next_) / camera_.options().fps; }
  const FaultSpan* ActiveSpan(const std::vector<FaultSpan>& spans) const {
    const auto found =
        std::find_if(spans.begin(), spans.end(), [&](const FaultSpan& s) { return s.Holds(Now()); });
    return found == spans.end() ? nullptr : &*found;
  }
  std::uint64_t FrameAfter(const FaultSpan& span) const {
    const auto frame =
        static_cast<std::uint64_t>(std::ceil((span.at_s + span.for_s) * camera_.options().fps));
    return std::max(next_ + 1, frame);
  }

  // Waits for the end of a freeze, at most for the timeout; true: frames come again.
  bool WaitForEnd(const FaultSpan& frozen, std::chrono::milliseconds timeout) {
    if (!thaw_) thaw_ = Clock::now() + DurationOf(frozen.for_s);
    std::this_thread::sleep_until(std::min(*thaw_, Clock::now() + timeout));
    if (Clock::now() < *thaw_) return false;
    thaw_.reset();
    next_ = FrameAfter(frozen);
    return State() == DeviceState::kStreaming;
  }

  Frame CaptureNext() {
    Frame frame;
    if (stops_to_come_.empty()) {
      frame = camera_.Capture(next_++);
    } else {
      const double stops = stops_to_come_.front();
      stops_to_come_.pop_front();
      frame = CaptureExposure(stops);
    }
    frame.host_time_s = EpochSeconds();
    ids_.Arrived(frame.id);
    if (faults_.incomplete > 0 &&
        UnitFloat(HashLattice(static_cast<std::int32_t>(frame.id), 0, 0,
                              static_cast<std::uint32_t>(camera_.options().seed))) < faults_.incomplete) {
      cv::Mat& pixels = frame.image.pixels;
      pixels.rowRange(pixels.rows / 2, pixels.rows).setTo(0);
      frame.status = FrameStatus::kIncomplete;
      ++statistics_.incomplete;
    } else {
      ++statistics_.delivered;
    }
    return frame;
  }

  // If it takes longer than a frame's time, the frames meanwhile do not come: the numbers show that.
  Frame CaptureExposure(double stops) {
    const SimulationOptions& options = camera_.options();
    const double exposure_s = std::clamp(options.exposure_s * std::exp2(stops), kShortestS, kLongestS);
    Frame frame = camera_.Capture(next_, exposure_s);
    frame.asked_stops = stops;
    next_ += static_cast<std::uint64_t>(std::max(1.0, std::ceil(exposure_s * options.fps)));
    return frame;
  }

  static constexpr double kShortestS = 1e-5, kLongestS = 1;
  DeviceUri uri_;
  SimulatedCamera camera_;
  const SimulatedFaults faults_;
  bool started_ = false, lost_ = false;
  std::uint64_t next_ = 0;
  std::deque<double> stops_to_come_;
  std::optional<Clock::time_point> thaw_;
  DeviceStatistics statistics_;
  FrameIdCounter ids_;
};

}  // namespace

std::unique_ptr<Device> OpenSimulatedDevice(const DeviceUri& uri, std::shared_ptr<const HandMotion> hand) {
  if (uri.path == "board" || uri.path == "card") return OpenSimulatedBoard(uri);
  if (uri.path == "chart" || uri.path == "grey") return OpenSimulatedChart(uri);
  const std::vector<std::string> scenes = Scene::Names();
  if (std::find(scenes.begin(), scenes.end(), uri.path) == scenes.end())
    throw Refused(uri, fmt::format("there is no scene '{}'", uri.path),
                  fmt::format("there are {}, and for calibration board, card, chart and grey",
                              fmt::join(scenes, ", ")));
  return std::make_unique<SimulatedDevice>(uri, std::move(hand));
}

}  // namespace ulf::acquisition
