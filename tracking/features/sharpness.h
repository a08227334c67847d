// Measures an image's sharpness relative to the recent ones, so that blur stands out in any scene.
#pragma once

#include <deque>

#include <opencv2/core.hpp>

namespace ulf::tracking {

// The pyramid level on which sharpness is measured: finer ones show noise. Guessed.
inline constexpr int kSharpnessLevel = 2;
// Reduces an image without a pyramid to that level's size and to at most 2,000 px of width.
cv::Mat ForSharpness(const cv::Mat& gray);

class Sharpness {
 public:
  // Returns the fine detail of this frame divided by the recent frames' median; 1 for the first frame.
  // `reduced`: grey, on kSharpnessLevel.
  double Step(const cv::Mat& reduced);

 private:
  // The median is over so many frames, about a second. Fewer adapt to a blurred stretch, more to a scene that
  // is gone. Guessed.
  static constexpr std::size_t kRecent = 31;
  std::deque<double> recent_;
};

}  // namespace ulf::tracking
