// Checks a capture before its first view: each item has a finding and, where it failed, what to do.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "acquisition/device/device.h"
#include "acquisition/link/link_facts.h"
#include "coverage/bound/capture_prediction.h"
#include "coverage/bound/criterion.h"
#include "coverage/bound/view_decision.h"
#include "coverage/session/light_and_focus.h"
#include "coverage/session/watch/mistake_watch.h"
#include "tracking/estimation/calibration_check.h"

namespace ulf::coverage {

struct PreflightItem {
  // "calibration", "light", "exposure", "white balance", "focus", "disk", "tracking"; "lamps", "lens" and
  // "views" where something is wrong with them; "link", or what of it is not in order (LinkFact::name).
  std::string name;
  std::optional<bool> in_order;  // none: unknown
  std::string words;             // the finding and, where it is not in order, what to do
  // True: while the item is not in order, recording does not begin, because views would be worthless. False:
  // the item is a warning.
  bool holds_start = true;
};

struct PreflightInput {
  FrameSource source = FrameSource::kCamera;
  bool resumed = false;            // there are views of earlier sessions
  std::optional<bool> calibrated;  // false: a focal length and no distortion; none: not known
  std::string calibration_source;
  bool lens_is_sought = false;  // LensUse::kRefine
  std::optional<tracking::RefinedLens> lens_found = {};
  std::optional<tracking::CalibrationCheck> lens_contradicted = {};
  acquisition::HeldAutomatics held;
  PictureFinding picture = {};
  std::optional<CapturePrediction> prediction;
  std::optional<Cap> cap = std::nullopt;  // none: the operator ends the capture
  bool without_subject = false;
  std::uint64_t bytes_per_view = 0;  // at most
  std::optional<std::uint64_t> disk_left_bytes;
  std::vector<acquisition::LinkFact> link = {};  // empty: the camera has none
  std::vector<NoticedMistake> mistakes = {};     // so far
  bool has_pose = true;                          // of the present frame
  std::string tracking_words = {};               // why it has none
  // PoseErrorPx() of a view taken now; none: the pose is given, or there is no subject yet.
  std::optional<double> pose_error_px;
};

// Returns the items in the order in which the display lists them.
std::vector<PreflightItem> Preflight(const PreflightInput& input);

// Returns what holds the start: "light: too dark ...; disk: ..."; empty when nothing does.
std::string HoldsInWords(const std::vector<PreflightItem>& items);

// Reports before the session's first view, once each, how many views to expect and which checks fail.
class PreflightReporter {
 public:
  explicit PreflightReporter(std::function<void(const std::string&)> say) : say_(std::move(say)) {}

  // Makes the prediction due again, for another subject.
  void Reset() { prediction_.reset(); }
  // Returns true until Expect() has made a prediction, for which the subject's distance must be known.
  bool IsDue() const { return !prediction_; }
  // Predicts the capture and reports it (capture_prediction.h); nothing happens where no view can cover.
  void Expect(const CriterionSetup& setup, const std::optional<Cap>& cap, double until_share, bool metric,
              FrameSource source);
  // Call it while the session has recorded no view, with `input` without its prediction. Reports each failed
  // check the first time, but "tracking" only after the prediction or, without a subject, after thirty checks
  // in a row without a pose, because the first frames have none, and never a lens that images contradict,
  // which RunningCapture reports.
  void Check(PreflightInput input);
  const std::vector<PreflightItem>& preflight() const { return preflight_; }
  const std::optional<CapturePrediction>& prediction() const { return prediction_; }
  // Returns the sum of the views that are recorded and those that the open part of the cap will take; none
  // without a prediction, a cap or a map.
  std::optional<double> ViewsExpected(std::size_t recorded, const CoverageMap* map) const;

 private:
  const std::function<void(const std::string&)> say_;
  std::optional<CapturePrediction> prediction_;
  double until_share_ = 1;
  std::vector<PreflightItem> preflight_;
  int checks_without_pose_ = 0;
  std::set<std::string> said_;  // names of failed checks
};

}  // namespace ulf::coverage
