// What a capture reports before its first view: how many views to expect, and which preflight checks fail.
// Each is reported once.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "coverage/bound/capture_prediction.h"
#include "coverage/session/capture_state.h"
#include "coverage/session/preflight.h"

namespace ulf::coverage {

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
