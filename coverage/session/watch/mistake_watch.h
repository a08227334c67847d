// Detects the mistakes that spoil a capture without stopping it, each with its remedy
// (docs/capture.md#mistakes).
//
// It collects the evidence of the pictures themselves (light_watch.h, focus_watch.h, dust_watch.h), of the
// preflight and the tracker, and the camera's report of its automatics.
#pragma once

#include <array>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/device/device.h"
#include "core/frames/frame.h"
#include "coverage/bound/view_decision.h"
#include "coverage/session/watch/dust_watch.h"
#include "coverage/session/watch/focus_watch.h"
#include "coverage/session/watch/light_watch.h"
#include "coverage/session/watch/picture_tracks.h"
#include "tracking/estimation/calibration_check.h"
#include "tracking/tracker/readout.h"

namespace ulf::coverage {

enum class Mistake {
  kOutOfFocus,
  kAutoExposure,
  kFocusHunts,
  kRollingShutter,
  kFlicker,
  kUnsteadyLight,
  kDust,
  kWrongLens,
};
inline constexpr std::array kMistakes{
    Mistake::kOutOfFocus, Mistake::kAutoExposure,  Mistake::kFocusHunts, Mistake::kRollingShutter,
    Mistake::kFlicker,    Mistake::kUnsteadyLight, Mistake::kDust,       Mistake::kWrongLens};
const char* Name(Mistake mistake);  // for people and programs: "out of focus", "auto exposure", ...
// Returns the remedy in sentences, without the last full stop; what can be changed for later captures only
// begins with "The next time". `compensated`: the tracker compensates the rolling shutter.
std::string CureOf(Mistake mistake, FrameSource source, bool compensated = false);

struct NoticedMistake {
  Mistake mistake = Mistake::kOutOfFocus;
  std::string finding, cure;       // a sentence each, without its full stop
  double first_s = 0, last_s = 0;  // when it was seen, by the device's clock, since the first frame
  // "flickering lamps: the lamps' light goes up and down by 25 %. Expose for ..."
  std::string InWords() const;
  // Returns whether it is still seen, or was lately.
  bool IsSeenAt(double seconds) const { return seconds - last_s < 15; }  // guessed
};

// Returns the mistake that explains why frames are refused for this reason. Returns null when none does.
const NoticedMistake* MistakeForReason(Reason reason, const std::vector<NoticedMistake>& noticed);

// A picture with less MistakeSigns::fine_detail is out of focus. Measured: light_and_focus.h.
inline constexpr double kLeastFineDetail = 0.8;

// Describes what device, tracker and preflight know of a frame.
struct MistakeSigns {
  acquisition::HeldAutomatics held = {};
  std::optional<double> fine_detail = {};  // of the best of the last frames (light_and_focus.h)
  // IsBadlyExposed(): clipped or black pictures show nothing of light, lens and dust.
  bool badly_exposed = false;
  std::optional<tracking::CalibrationCheck> lens_contradicted = {};
  std::optional<tracking::Readout> rolling_shutter = {};
  // The camera is fixed and the subject turns: what stays in place in the picture is no dust.
  bool subject_turns = false;
};

class MistakeWatch {
 public:
  explicit MistakeWatch(FrameSource source) : source_(source) {}

  // Call it after each complete live frame. Returns the mistakes that were not noticed before.
  std::vector<NoticedMistake> Update(const Frame& frame, const MistakeSigns& signs);
  // Adds what the tracker knows only after the last frame.
  void Finish(const std::optional<tracking::CalibrationCheck>& lens,
              const std::optional<tracking::Readout>& rolling_shutter);
  // Returns the mistakes so far, each once. One that another explains (soft pictures look like dust) is gone.
  const std::vector<NoticedMistake>& noticed() const { return noticed_; }

 private:
  static bool IsExplainedByBlur(Mistake mistake);
  void SuspendMistakesOfBlur();
  void Note(Mistake mistake, std::string finding, bool compensated = false);
  void NoteHunting(double factor);
  void NoteLight(const LightFinding& light, const acquisition::HeldAutomatics& held);
  void NoteFocus(const MistakeSigns& signs);
  void WithdrawLens();
  void NoteLens(const tracking::CalibrationCheck& lens);
  void NoteShutter(const tracking::Readout& rolling_shutter);
  void NoteReportedExposure(const Frame& frame, const acquisition::HeldAutomatics& held);

  const FrameSource source_;
  PictureTracks tracks_;
  LightWatch light_;
  FocusWatch focus_;
  DustWatch dust_;
  struct ReportedExposure {
    double time_s = 0, log_exposure = 0;
  };
  std::deque<ReportedExposure> reported_;  // of late, by frames whose exposure is known
  std::optional<double> first_frame_s_, blurred_since_s_, automatic_since_s_;
  double now_s_ = 0;                             // since the first frame
  std::vector<NoticedMistake> noticed_, fresh_;  // fresh: in the last frame for the first time
  std::optional<double> soft_until_s_;           // since the first frame; what soft pictures look like waits
};

}  // namespace ulf::coverage
