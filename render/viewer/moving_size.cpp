#include "render/viewer/moving_size.h"

#include <algorithm>
#include <cmath>

namespace ulf::render {

cv::Size MovingSize::For(const cv::Size& screen) const {
  const auto part = [&](int px) { return std::max(1, static_cast<int>(std::ceil(kShares[step_] * px))); };
  return {part(screen.width), part(screen.height)};
}

// Two successive frames must agree, because a single frame may have waited for photographs or a shader.
void MovingSize::AddFrame(double ms, const cv::Size& drawn, const cv::Size& screen) {
  const double target_ms = 1000 / options_.fps;
  const double full_ms = ms * screen.area() / std::max(1, drawn.area());
  const auto [least_ms, most_ms] = std::minmax(full_ms, full_ms_);
  const auto ms_at = [&](double of_full_ms, std::size_t step) {
    return of_full_ms * kShares[step] * kShares[step];
  };
  if (step_ > 0 && ms_at(most_ms, step_ - 1) < options_.quick_enough * target_ms) --step_;
  while (step_ + 1 < kShares.size() && ms_at(least_ms, step_) > options_.too_slow * target_ms) ++step_;
  full_ms_ = full_ms;
}

}  // namespace ulf::render
