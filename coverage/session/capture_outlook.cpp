#include "coverage/session/capture_outlook.h"

#include <fmt/format.h>

#include <algorithm>

namespace ulf::coverage {

void CaptureOutlook::Expect(const CriterionSetup& setup, const std::optional<Cap>& cap, double until_share,
                            bool metric) {
  prediction_ = Predict(setup, cap, until_share);
  until_share_ = until_share;
  if (prediction_) say_(InWords(*prediction_, setup.threshold_px, metric));
}

void CaptureOutlook::Check(PreflightInput input) {
  const bool first = preflight_.empty();
  input.prediction = prediction_;
  preflight_ = Preflight(input);
  if (!first) return;
  for (const PreflightItem& item : preflight_)
    if (item.in_order == false) say_(fmt::format("before the first view: {}: {}", item.name, item.words));
}

void CaptureOutlook::Describe(CaptureState& state) const {
  state.prediction = prediction_;
  state.preflight = preflight_;
  // What is recorded, and what the open rest will take.
  if (prediction_ && prediction_->views && state.coverage)
    state.views_expected =
        static_cast<double>(state.view_ids.size()) +
        std::max(0.0, 1 - state.coverage->CoveredShare() / until_share_) * prediction_->views->usual;
}

}  // namespace ulf::coverage
