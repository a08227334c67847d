// What a capture tells a person before its first view: what it will take, and what is not in order. Each is
// said once.
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

  // Another subject: expected anew.
  void Forget() { prediction_.reset(); }
  // Once the subject is there and a pose says how far away it is.
  bool IsDue() const { return !prediction_; }
  void Expect(const CriterionSetup& setup, const std::optional<Cap>& cap, double until_share, bool metric);
  // While no view is recorded, with all but the prediction; what is not in order is said the first time.
  void Check(PreflightInput input);
  // `state` knows already what is recorded.
  void Describe(CaptureState& state) const;

 private:
  const std::function<void(const std::string&)> say_;
  std::optional<CapturePrediction> prediction_;
  double until_share_ = 1;
  std::vector<PreflightItem> preflight_;
};

}  // namespace ulf::coverage
