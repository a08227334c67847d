// The size at which a picture is drawn while its camera moves: the largest that allows thirty pictures a second,
// in steps that halve the number of pixels, and not below a quarter of the width. Assumes that the time is proportional to
// the number of pixels.
#pragma once

#include <array>
#include <cstddef>
#include <opencv2/core.hpp>

namespace ulf::render {

class MovingSize {
 public:
  static constexpr std::array<double, 5> kShares{1, 0.707, 0.5, 0.354, 0.25};  // of width and height

  cv::Size For(const cv::Size& screen) const;
  // Records the time of a frame whose picture had the size `drawn` on a screen of `screen`, whether it moved
  // or not.
  void AddFrame(double ms, const cv::Size& drawn, const cv::Size& screen);

 private:
  std::size_t step_ = 0;
  double full_ms_ = 0;  // the time of the last frame, converted to full size
};

}  // namespace ulf::render
