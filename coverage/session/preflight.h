// Before the first view: what to expect, and the checks with what each found and, where it failed, what to do.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/device/device.h"
#include "coverage/bound/capture_prediction.h"

namespace ulf::coverage {

struct PreflightItem {
  std::string name;  // "calibration", "exposure", "white balance", "focus", "disk", "views", "tracking"
  std::optional<bool> in_order;  // none: unknown
  std::string words;             // the finding and, where it is not in order, what to do
};

struct PreflightInput {
  std::optional<bool> calibrated;  // false: --focal-px and no distortion; none: poses and camera are given
  std::string calibration_source;
  acquisition::HeldAutomatics held;
  std::optional<CapturePrediction> prediction;
  std::optional<Cap> cap = std::nullopt;  // none: the operator ends the capture
  bool without_subject = false;
  std::uint64_t bytes_per_view = 0;  // at most
  std::optional<std::uint64_t> disk_left_bytes;
  bool has_pose = true;  // of the present frame
  // Of a view taken now (view_decision.h); none: the pose is given.
  std::optional<double> pose_error_px;
  double most_pose_error_px = 1;
};

std::vector<PreflightItem> Preflight(const PreflightInput& input);

struct CaptureState;

// What a capture reports before its first view, once each: how many views to expect, and which checks fail.
class CaptureOutlook {
 public:
  explicit CaptureOutlook(std::function<void(const std::string&)> say) : say_(std::move(say)) {}

  // For another subject: the prediction is due again.
  void Reset() { prediction_.reset(); }
  // True until Expect(), which needs the subject and its distance.
  bool IsDue() const { return !prediction_; }
  void Expect(const CriterionSetup& setup, const std::optional<Cap>& cap, double until_share, bool metric);
  // While no view is recorded. `input` without its prediction. Reports failed checks the first time.
  void Check(PreflightInput input);
  // Fills in prediction and preflight; `state` has its views and its coverage map already.
  void Describe(CaptureState& state) const;

 private:
  const std::function<void(const std::string&)> say_;
  std::optional<CapturePrediction> prediction_;
  double until_share_ = 1;
  std::vector<PreflightItem> preflight_;
};

}  // namespace ulf::coverage
