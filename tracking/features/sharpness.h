// Measures a frame's sharpness relative to the recent frames', so that blur stands out in any scene.
#pragma once

#include <deque>

#include <opencv2/core.hpp>

namespace ulf::tracking {

// The pyramid level on which sharpness is measured: finer ones show noise. Guessed.
inline constexpr int kSharpnessLevel = 2;
// Reduces a grey image (CV_8UC1) to that level's size, and to at most 2,000 px of width.
cv::Mat ForSharpness(const cv::Mat& gray);

// Call Step() once for every frame of a sequence.
class Sharpness {
 public:
  // Returns the variance of the Laplacian of this frame over its median in the recent frames; 1 for the first
  // frame, or if they show nothing. `reduced` is what ForSharpness() returns, or that level of a pyramid.
  double Step(const cv::Mat& reduced);

 private:
  // The median is over so many frames, about a second. Fewer adapt to blur, more to old scenes. Guessed.
  static constexpr std::size_t kRecent = 31;
  std::deque<double> recent_;
};

}  // namespace ulf::tracking
