#include "acquisition/aravis/aravis_exposures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "acquisition/aravis/aravis_automatics.h"
#include "acquisition/aravis/aravis_calls.h"
#include "acquisition/aravis/aravis_description.h"

namespace ulf::acquisition {
namespace {

constexpr int kFramesOnTheirWay = 3;                // with the exposure before; guessed
constexpr double kSameShare = 0.01, kSameS = 2e-6;  // cameras round their times
constexpr double kPatienceS = 3;                    // beside the exposure itself; guessed

bool AreTheSame(double a_s, double b_s) { return std::abs(a_s - b_s) <= kSameShare * b_s + kSameS; }

// Returns 0 and 0 when the camera does not tell.
std::pair<double, double> BoundsOf(const AravisNumber& number) {
  try {
    return number.Bounds("the camera");
  } catch (const Error&) {
    return {0, 0};
  }
}

// All or nothing: the first refusal ends it.
class FeatureWrites {
 public:
  explicit FeatureWrites(const AravisSession& session) : session_(session) {}
  FeatureWrites& Text(const char* feature, const std::string& value) {
    if (ok()) why_ = WriteSetting(session_, feature, value);
    return *this;
  }
  FeatureWrites& Whole(const char* feature, gint64 value) { return Text(feature, fmt::format("{}", value)); }
  FeatureWrites& Number(const AravisNumber& number, double value) {
    try {
      if (ok()) number.Write("the camera", value);
    } catch (const Error& error) {
      why_ = error.what();
    }
    return *this;
  }
  FeatureWrites& Do(const char* command) {
    if (ok()) why_ = FailureOf(arv_device_execute_command, session_.Device(), command).value_or("");
    return *this;
  }
  bool ok() const { return why_.empty(); }
  const std::string& why() const { return why_; }

 private:
  const AravisSession& session_;
  std::string why_;
};

}  // namespace

AravisExposures::AravisExposures(const AravisSession& session, bool frames_tell, bool triggered_by_software)
    : session_(session), frames_tell_(frames_tell), triggered_by_software_(triggered_by_software) {
  LookAgain();
}

void AravisExposures::LookAgain() {
  const bool is_automatic = IsAutomaticOn(session_, "ExposureAuto");
  const FeatureNames names = FindFeatureNames(FeaturesOf(session_.Camera()));
  exposure_ = {session_, names.exposure, names.exposure_us};
  if (is_automatic || !exposure_.Read() || IsReadOnly(session_, exposure_.Feature())) {
    kind_ = ExposureRequests::kNone;
    return;
  }
  const bool has_sequencer = frames_tell_ && session_.Has("SequencerMode") &&
                             session_.Has("SequencerConfigurationMode") &&
                             session_.Has("SequencerSetSelector") && session_.Has("SequencerSetNext");
  kind_ = has_sequencer ? ExposureRequests::kSequencer : ExposureRequests::kSetTime;
}

StillRequest AravisExposures::Request(const std::vector<double>& stops) {
  const MutexLock lock(mutex_);
  if (busy_ || kind_ == ExposureRequests::kNone || stops.empty()) return StillRequest::kBusy;
  asked_ = stops;
  busy_ = true;
  return StillRequest::kAsked;
}

bool AravisExposures::SetTime(double exposure_s) {
  FeatureWrites writes(session_);
  writes.Number(exposure_, 1e6 * exposure_s);
  if (!writes.ok())
    notes_.push_back(
        fmt::format("the camera does not take an exposure of {:g} s: {}", exposure_s, writes.why()));
  frames_since_set_ = 0;
  set_at_ = Clock::now();
  set_s_ = 1e-6 * exposure_.Read().value_or(0);
  return writes.ok();
}

// Set k is exposure k; the last leads to the first again, so that a frame that was lost comes once more.
bool AravisExposures::StartSequencer() {
  FeatureWrites writes(session_);
  writes.Text("SequencerMode", "Off").Text("SequencerConfigurationMode", "On");
  const auto sets = static_cast<gint64>(wanted_.size()) - 1;  // without the exposure before
  for (gint64 set = 0; set < sets; ++set) {
    writes.Whole("SequencerSetSelector", set);
    const double exposure_s = wanted_[static_cast<std::size_t>(set)].exposure_s;
    writes.Number(exposure_, 1e6 * exposure_s);
    if (session_.Has("SequencerPathSelector")) writes.Whole("SequencerPathSelector", 0);
    if (session_.Has("SequencerTriggerSource")) writes.Text("SequencerTriggerSource", "FrameStart");
    writes.Whole("SequencerSetNext", (set + 1) % sets).Do("SequencerSetSave");
  }
  if (session_.Has("SequencerSetStart")) writes.Whole("SequencerSetStart", 0);
  writes.Text("SequencerConfigurationMode", "Off").Text("SequencerMode", "On");
  if (writes.ok()) {
    set_at_ = Clock::now();
    return sequencer_runs_ = true;
  }
  notes_.push_back(fmt::format(
      "the camera's sequencer refuses ({}): each exposure time is set, and a frame awaited that has it",
      writes.why()));
  StopSequencer();
  kind_ = ExposureRequests::kSetTime;
  return false;
}

void AravisExposures::StopSequencer() {
  FeatureWrites(session_).Text("SequencerConfigurationMode", "Off");
  FeatureWrites(session_).Text("SequencerMode", "Off");
  sequencer_runs_ = false;
}

void AravisExposures::Step() {
  std::vector<double> stops;
  {
    const MutexLock lock(mutex_);
    stops = std::exchange(asked_, {});
  }
  if (stops.empty()) return;
  before_s_ = 1e-6 * exposure_.Read().value_or(0);
  const auto [least_us, most_us] = BoundsOf(exposure_);
  for (const double each : stops) {
    double exposure_s = before_s_ * std::exp2(each);
    if (most_us > least_us) {
      const double possible_s = std::clamp(exposure_s, 1e-6 * least_us, 1e-6 * most_us);
      if (!AreTheSame(possible_s, exposure_s) && !std::exchange(said_bounds_, true))
        notes_.push_back(
            fmt::format("the camera exposes from {:g} to {:g} s: an exposure of {:g} s of a bracket becomes "
                        "{:g} s; bracket fewer stops, or begin with another exposure",
                        1e-6 * least_us, 1e-6 * most_us, exposure_s, possible_s));
      exposure_s = possible_s;
    }
    wanted_.push_back({each, exposure_s});
  }
  wanted_.push_back({0, before_s_});
  if (kind_ != ExposureRequests::kSequencer || !StartSequencer()) SetTime(wanted_.front().exposure_s);
}

void AravisExposures::Next() {
  wanted_.pop_front();
  if (sequencer_runs_) {
    set_at_ = Clock::now();
    if (wanted_.size() > 1) return;
    StopSequencer();
  }
  if (!wanted_.empty()) {
    SetTime(wanted_.front().exposure_s);
    return;
  }
  before_s_ = 0;
  const MutexLock lock(mutex_);
  busy_ = false;
}

void AravisExposures::Label(Frame& frame) {
  if (wanted_.empty()) return;
  ++frames_since_set_;
  const Wanted wanted = wanted_.front();
  const bool is_last = wanted_.size() == 1;  // the exposure before
  const double target_s = sequencer_runs_ ? wanted.exposure_s : set_s_;
  bool has_it = false;
  if (frames_tell_) {
    has_it = AreTheSame(frame.exposure_s, target_s);
  } else {
    has_it = frames_since_set_ > (triggered_by_software_ ? 1 : kFramesOnTheirWay);
    frame.exposure_s = has_it ? set_s_ : 0;
  }
  if (has_it) {
    if (!is_last) frame.asked_stops = wanted.stops;
    return Next();
  }
  const double waited_s = std::chrono::duration<double>(Clock::now() - set_at_).count();
  if (waited_s < kPatienceS + target_s) return;
  if (!is_last)
    notes_.push_back(fmt::format(
        "no frame came with an exposure of {:g} s within {:.1f} s; the bracket goes on without it", target_s,
        waited_s));
  Next();
}

void AravisExposures::Restore() {
  if (before_s_ <= 0) return;
  if (sequencer_runs_) StopSequencer();
  SetTime(before_s_);
  wanted_.clear();
  before_s_ = 0;
}

}  // namespace ulf::acquisition
