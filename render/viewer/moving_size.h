// The size at which a picture is drawn while its camera moves: the largest that allows MovingSizeOptions::fps
// pictures a second, in steps that halve the number of pixels, and not below a quarter of the width. Assumes
// that the time is proportional to the number of pixels.
#pragma once

#include <array>
#include <cstddef>
#include <opencv2/core.hpp>

namespace ulf::render {

struct MovingSizeOptions {
  double fps = 30;  // wanted
  // In times of 1 / fps. A frame that takes longer than the first makes the size smaller; one that would take
  // less than the second at the next larger size makes it larger. Guessed.
  double too_slow = 1.2, quick_enough = 0.8;
};

class MovingSize {
 public:
  explicit MovingSize(const MovingSizeOptions& options = {}) : options_(options) {}
  static constexpr std::array<double, 5> kShares{1, 0.707, 0.5, 0.354, 0.25};  // of width and height

  cv::Size For(const cv::Size& screen) const;
  // Records the time of a frame whose picture had the size `drawn` on a screen of `screen`, whether it moved
  // or not.
  void AddFrame(double ms, const cv::Size& drawn, const cv::Size& screen);

 private:
  MovingSizeOptions options_;
  std::size_t step_ = 0;
  double full_ms_ = 0;  // the time of the last frame, converted to full size
};

}  // namespace ulf::render
