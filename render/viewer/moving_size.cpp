#include "render/viewer/moving_size.h"

#include <algorithm>
#include <cmath>

namespace ulf::render {
namespace {

constexpr double kTargetMs = 1000 / kMovingFps;
constexpr double kTooSlow = 1.2, kQuickEnough = 0.8;  // of the target; between them the size stays

}  // namespace

cv::Size MovingSize::For(const cv::Size& screen) const {
  const auto part = [&](int px) { return std::max(1, static_cast<int>(std::ceil(kShares[step_] * px))); };
  return {part(screen.width), part(screen.height)};
}

// One frame alone, which may have read photographs or compiled a shader, says little: two must agree.
void MovingSize::Took(double ms, const cv::Size& drawn, const cv::Size& screen) {
  const double full_ms = ms * screen.area() / std::max(1, drawn.area());
  const auto [least_ms, most_ms] = std::minmax(full_ms, full_ms_);
  const auto ms_at = [&](double of_full_ms, std::size_t step) {
    return of_full_ms * kShares[step] * kShares[step];
  };
  if (step_ > 0 && ms_at(most_ms, step_ - 1) < kQuickEnough * kTargetMs) --step_;
  while (step_ + 1 < kShares.size() && ms_at(least_ms, step_) > kTooSlow * kTargetMs) ++step_;
  full_ms_ = full_ms;
}

}  // namespace ulf::render
