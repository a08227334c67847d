// How sharp a picture is, against the recent ones: a blurred frame stands out, whatever the scene.
#pragma once

#include <deque>

#include <opencv2/core.hpp>

namespace ulf::tracking {

// The level of a picture's pyramid that its sharpness is judged on, and the same without a pyramid, at most
// 2,000 px wide.
inline constexpr int kSharpnessLevel = 2;
cv::Mat ForSharpness(const cv::Mat& gray);

class Sharpness {
 public:
  // Fine detail of this frame over the recent frames' median; 1 while there are none. `below_full`: grey, a
  // little below the picture's own resolution, where noise would rule.
  double Step(const cv::Mat& below_full);

 private:
  std::deque<double> recent_;
};

}  // namespace ulf::tracking
