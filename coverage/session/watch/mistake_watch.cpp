#include "coverage/session/watch/mistake_watch.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/counted.h"
#include "core/base/error.h"

namespace ulf::coverage {

const char* Name(Mistake mistake) {
  constexpr std::array kNames{"out of focus",     "auto exposure",  "auto focus hunts", "rolling shutter",
                              "flickering lamps", "unsteady light", "dust on the lens", "wrong lens"};
  static_assert(kNames.size() == kMistakes.size());
  return kNames[static_cast<std::size_t>(mistake)];
}

std::string CureOf(Mistake mistake, FrameSource source, bool compensated) {
  const bool is_taken = IsTaken(source);
  const auto even_out = [] {
    return fmt::format("Even the views out over a mesh when you render them ({} fit)", Parameter("light"));
  };
  const auto begin_again = [] { return fmt::format("begin again with {} refine", Parameter("intrinsics")); };
  switch (mistake) {
    case Mistake::kOutOfFocus:
      return is_taken
                 ? "No rendering brings the detail back. The next time focus on the subject and fix the focus"
                 : "Focus on the subject and fix the focus; move slowly";
    case Mistake::kAutoExposure:
      return is_taken ? even_out() + ". The next time switch auto exposure off"
                      : fmt::format("Switch auto exposure off and set the exposure ({})", WhereToSet(source));
    case Mistake::kFocusHunts:
      return is_taken ? "Soft pictures stay soft. The next time switch auto focus off, and focus once on the "
                        "subject"
                      : "Switch auto focus off, at the lens or by the camera's settings, and focus once on "
                        "the subject";
    case Mistake::kRollingShutter: {
      const std::string let = fmt::format("Let it be compensated ({} auto)", Parameter("readout_ms"));
      const std::string leaves = "it is compensated, which leaves about twice the error of a global shutter";
      if (is_taken) return compensated ? "It" + leaves.substr(2) : let;
      return compensated ? "Move slowly: " + leaves
                         : let + ", and move slowly; or take a camera with a global shutter";
    }
    case Mistake::kFlicker:
      return fmt::format(
          "{} for 1/50 or 1/25 s (1/60 or 1/30 s where mains have 60 Hz), or take lamps that do not flicker",
          is_taken ? even_out() + "; bands stay. The next time expose" : "Expose");
    case Mistake::kUnsteadyLight:
      return is_taken ? even_out() + ". The next time keep lamps, daylight and shadows as they are"
                      : "Keep lamps, daylight and shadows as they are while you capture";
    case Mistake::kDust:
      return fmt::format("{} the lens, and if that does not help the glass before the sensor",
                         is_taken ? "The spots stay in these pictures. The next time clean" : "Clean");
    case Mistake::kWrongLens:
      return is_taken ? fmt::format("Give the calibration of the camera that took them ({}), or {}",
                                    Parameter("calibration"), begin_again())
                      : "Calibrate with this lens at this zoom (ulf calibrate), or " + begin_again();
  }
  return {};
}

std::string NoticedMistake::InWords() const {
  return fmt::format("{}: {}. {}", Name(mistake), finding, cure);
}

const NoticedMistake* MistakeForReason(Reason reason, const std::vector<NoticedMistake>& noticed) {
  using enum Mistake;
  const auto stands_behind = [reason](Mistake mistake) {
    switch (reason) {
      case Reason::kUnsettled:
        return mistake == kFlicker || mistake == kAutoExposure || mistake == kUnsteadyLight;
      case Reason::kBlur:
        return mistake == kOutOfFocus || mistake == kFocusHunts;
      case Reason::kZoomed:
        return mistake == kWrongLens || mistake == kFocusHunts;
      default:
        return false;
    }
  };
  const auto found = std::ranges::find_if(noticed, stands_behind, &NoticedMistake::mistake);
  return found == noticed.end() ? nullptr : &*found;
}

// Returns what soft pictures, and a focus that goes to and fro, look like: corners move, edges darken and
// brighten.
bool MistakeWatch::IsExplainedByBlur(Mistake mistake) {
  return mistake == Mistake::kDust || mistake == Mistake::kUnsteadyLight || mistake == Mistake::kWrongLens ||
         mistake == Mistake::kRollingShutter;
}

void MistakeWatch::SuspendMistakesOfBlur() {
  constexpr double kAfterwards_s = 5;  // guessed
  if (!soft_until_s_)
    std::erase_if(noticed_, [](const NoticedMistake& noticed) { return IsExplainedByBlur(noticed.mistake); });
  soft_until_s_ = now_s_ + kAfterwards_s;
}

void MistakeWatch::Note(Mistake mistake, std::string finding, bool compensated) {
  if (IsExplainedByBlur(mistake) && soft_until_s_ && now_s_ < *soft_until_s_) return;
  const auto known = std::ranges::find(noticed_, mistake, &NoticedMistake::mistake);
  if (known != noticed_.end()) {
    known->last_s = now_s_;
    return;
  }
  noticed_.push_back({.mistake = mistake,
                      .finding = std::move(finding),
                      .cure = CureOf(mistake, source_, compensated),
                      .first_s = now_s_,
                      .last_s = now_s_});
  fresh_.push_back(noticed_.back());
}

void MistakeWatch::NoteHunting(double factor) {
  SuspendMistakesOfBlur();
  Note(Mistake::kFocusHunts, fmt::format("pictures of the same things turn soft and sharp again and again, "
                                         "their detail by a factor of {:.1f}",
                                         factor));
}

std::vector<NoticedMistake> MistakeWatch::Update(const Frame& frame, const MistakeSigns& signs) {
  fresh_.clear();
  if (!first_frame_s_) first_frame_s_ = frame.device_time_s;
  now_s_ = frame.device_time_s - *first_frame_s_;
  NoteReportedExposure(frame, signs.held);
  NoteFocus(signs);
  if (const auto pair = tracks_.Update(frame.device_time_s, frame.image); pair && !signs.badly_exposed) {
    const double told = reported_.size() > 1 && reported_.back().time_s == pair->now_s &&
                                reported_.rbegin()[1].time_s == pair->before_s
                            ? reported_.back().log_exposure - reported_.rbegin()[1].log_exposure
                            : 0;
    NoteLight(light_.Update(*pair, told), signs.held);
    focus_.Update(*pair);
    if (!signs.subject_turns) dust_.Update(*pair);
    if (focus_.HuntingAmplitude() && focus_.LastSwingS() + 1 > frame.device_time_s)
      NoteHunting(*focus_.HuntingAmplitude());
    if (const std::vector<DustSpot>& spots = dust_.spots(); !spots.empty()) {
      const DustSpot& darkest = *std::ranges::max_element(spots, {}, &DustSpot::kept_off);
      Note(Mistake::kDust,
           fmt::format("{} where {} in the picture while the scene moves on, the darkest {:.0f} % from the "
                       "left and {:.0f} % from the top",
                       spots.size() == 1 ? "a dark spot stays" : Counted(spots.size(), "dark spot") + " stay",
                       spots.size() == 1 ? "it is" : "they are", 100 * darkest.at.x, 100 * darkest.at.y));
    }
  }
  if (signs.rolling_shutter) NoteShutter(*signs.rolling_shutter);
  if (signs.lens_contradicted)
    NoteLens(*signs.lens_contradicted);
  else
    WithdrawLens();
  return fresh_;
}

void MistakeWatch::Finish(const std::optional<tracking::CalibrationCheck>& lens,
                          const std::optional<tracking::Readout>& rolling_shutter) {
  if (soft_until_s_) return;  // what is said now rests on all pictures, the soft ones, too
  if (rolling_shutter) NoteShutter(*rolling_shutter);
  if (lens && lens->Wrong())
    NoteLens(*lens);
  else if (lens)
    WithdrawLens();
}

// Rows of a rolling shutter look like another lens until they are known.
void MistakeWatch::WithdrawLens() {
  std::erase_if(noticed_,
                [](const NoticedMistake& noticed) { return noticed.mistake == Mistake::kWrongLens; });
}

void MistakeWatch::NoteLens(const tracking::CalibrationCheck& lens) {
  if (!lens.Wrong()) return;
  Note(Mistake::kWrongLens, lens.Text());
}

void MistakeWatch::NoteShutter(const tracking::Readout& rolling_shutter) {
  const auto& contradicted = rolling_shutter.contradicted;
  const bool was_given = !rolling_shutter.sigma_s && !contradicted;  // whoever gives its time knows of it
  if (was_given ||
      std::ranges::find(noticed_, Mistake::kRollingShutter, &NoticedMistake::mistake) != noticed_.end())
    return;
  constexpr double kLeast_s = 0.005;  // less bends nothing that one sees, and fast hands make it up
  const double readout_s = contradicted ? contradicted->readout_s : rolling_shutter.readout_s;
  if (std::abs(readout_s) < kLeast_s) return;
  Note(Mistake::kRollingShutter,
       fmt::format("the rows of a picture are taken one after the other, within {:.0f} ms, which bends what "
                   "a moving camera sees",
                   1000 * std::abs(readout_s)),
       rolling_shutter.compensated && !contradicted);
}

// Notes changes of exposure that the camera itself reports. Automatics that only settle, and a hand on the
// dial, are no mistake.
void MistakeWatch::NoteReportedExposure(const Frame& frame, const acquisition::HeldAutomatics& held) {
  constexpr double kSettles_s = 3, kWindow_s = 5, kLeastStep = 0.01, kLeastRange = 0.12;
  constexpr int kFewestSteps = 8;
  if (held.exposure != false)
    automatic_since_s_.reset();
  else if (!automatic_since_s_)
    automatic_since_s_ = now_s_;
  if (automatic_since_s_ && now_s_ - *automatic_since_s_ >= kSettles_s)
    Note(Mistake::kAutoExposure, "the camera's auto exposure is on");
  if (frame.exposure_s <= 0 || frame.gain <= 0) return;
  reported_.push_back({frame.device_time_s, std::log(frame.exposure_s * frame.gain)});
  while (std::abs(frame.device_time_s - reported_.front().time_s) > kWindow_s) reported_.pop_front();
  int steps = 0;
  for (std::size_t i = 1; i < reported_.size(); ++i)
    steps += std::abs(reported_[i].log_exposure - reported_[i - 1].log_exposure) > kLeastStep;
  const auto [shortest, longest] = std::ranges::minmax(reported_, {}, &ReportedExposure::log_exposure);
  if (steps >= kFewestSteps && longest.log_exposure - shortest.log_exposure > kLeastRange &&
      now_s_ > kSettles_s + kWindow_s)
    Note(Mistake::kAutoExposure,
         fmt::format("the camera changes its exposure all the time, by {:.1f} stops within {:.0f} s",
                     (longest.log_exposure - shortest.log_exposure) / std::log(2), kWindow_s));
}

void MistakeWatch::NoteLight(const LightFinding& light, const acquisition::HeldAutomatics& held) {
  const auto is_now = [&](double time_s) { return time_s - *first_frame_s_ >= now_s_; };
  if (light.flickers && is_now(light.flickered_s))
    Note(Mistake::kFlicker,
         fmt::format("the light of the lamps goes up and down by {:.0f} %{}", 100 * *light.flickers,
                     light.bands ? fmt::format(", in {:.1f} bands over the picture", *light.bands)
                                 : ", from picture to picture"));
  if (!light.changed || !is_now(light.changed_s)) return;
  const double stops = *light.changed / std::log(2);
  const std::string finding =
      fmt::format("within two seconds the same things became {:.1f} stops {}{}", std::abs(stops),
                  stops > 0 ? "brighter" : "darker",
                  held.exposure == true ? ", though the camera holds its exposure" : "");
  Note(held.exposure == true ? Mistake::kUnsteadyLight : Mistake::kAutoExposure, finding);
}

// The best of two seconds decides (light_and_focus.h); a moment more, so that a hand before the lens does
// not.
void MistakeWatch::NoteFocus(const MistakeSigns& signs) {
  constexpr double kStays_s = 2;
  if (signs.badly_exposed || !signs.fine_detail || *signs.fine_detail >= kLeastFineDetail) {
    blurred_since_s_.reset();
    return;
  }
  if (!blurred_since_s_) blurred_since_s_ = now_s_;
  if (now_s_ - *blurred_since_s_ < kStays_s) return;
  SuspendMistakesOfBlur();
  Note(Mistake::kOutOfFocus,
       fmt::format("the pictures are blurred, fine detail is {:.2f} of the coarser where {:g} are needed",
                   *signs.fine_detail, kLeastFineDetail));
}

}  // namespace ulf::coverage
