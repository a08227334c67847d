// Measures how sharp an image is relative to the recent ones, so that a blurred frame stands out in any
// scene.
#pragma once

#include <deque>

#include <opencv2/core.hpp>

namespace ulf::tracking {

// The pyramid level on which sharpness is measured: finer ones show noise. Guessed.
inline constexpr int kSharpnessLevel = 2;
// An image without a pyramid, reduced to that level's size and to at most 2,000 px of width.
cv::Mat ForSharpness(const cv::Mat& gray);

class Sharpness {
 public:
  // Fine detail of this frame divided by the recent frames' median; 1 for the first frame. `reduced`: grey,
  // on kSharpnessLevel.
  double Step(const cv::Mat& reduced);

 private:
  // Frames of the median: about a second of them. Fewer follow a blurred stretch, more an old scene. Guessed.
  static constexpr std::size_t kRecent = 31;
  std::deque<double> recent_;
};

}  // namespace ulf::tracking
