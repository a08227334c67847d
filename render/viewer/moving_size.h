// Chooses the size at which a picture is drawn while its camera moves: the largest that allows the wanted
// frame rate, in steps that halve the number of pixels, and not below a quarter of the width. It assumes that
// the time is proportional to the number of pixels.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <opencv2/core.hpp>

namespace ulf::render {

class MovingSize {
 public:
  // `fps` is the wanted number of pictures a second.
  explicit MovingSize(double fps = 30) : fps_(fps) {}

  static constexpr std::array<double, 5> kShares{1, 0.707, 0.5, 0.354, 0.25};  // of width and height

  cv::Size SizeFor(const cv::Size& screen) const {
    const auto part = [&](int px) { return std::max(1, static_cast<int>(std::ceil(kShares[step_] * px))); };
    return {part(screen.width), part(screen.height)};
  }
  // Records the time of a frame whose picture had the size `drawn` on a screen of `screen`, whether it moved
  // or not. Two successive frames must agree, because one may have waited for photographs.
  void AddFrame(double ms, const cv::Size& drawn, const cv::Size& screen) {
    const double target_ms = 1000 / fps_;
    const double full_ms = ms * screen.area() / std::max(1, drawn.area());
    const auto [least_ms, most_ms] = std::minmax(full_ms, full_ms_);
    const auto ms_at = [&](double of_full_ms, std::size_t step) {
      return of_full_ms * kShares[step] * kShares[step];
    };
    if (step_ > 0 && ms_at(most_ms, step_ - 1) < kQuickEnough * target_ms) --step_;
    while (step_ + 1 < kShares.size() && ms_at(least_ms, step_) > kTooSlow * target_ms) ++step_;
    full_ms_ = full_ms;
  }

 private:
  // Limits in units of 1 / fps: a frame that takes longer than the first reduces the size; one that would
  // take less than the second at the next larger size enlarges it. Guessed.
  static constexpr double kTooSlow = 1.2, kQuickEnough = 0.8;

  double fps_;
  std::size_t step_ = 0;
  double full_ms_ = 0;  // the time of the last frame, converted to full size
};

}  // namespace ulf::render
