// How large a picture is drawn while its camera moves: as large as keeps up with kMovingFps, in steps that
// halve the pixels, never below a quarter of the width. Times are taken to go with the number of pixels.
#pragma once

#include <array>
#include <cstddef>
#include <opencv2/core.hpp>

namespace ulf::render {

inline constexpr double kMovingFps = 30;

class MovingSize {
 public:
  static constexpr std::array<double, 5> kShares{1, 0.707, 0.5, 0.354, 0.25};  // of width and height

  cv::Size For(const cv::Size& screen) const;
  // A frame whose picture was drawn at `drawn` of `screen`, moving or not.
  void Took(double ms, const cv::Size& drawn, const cv::Size& screen);

 private:
  std::size_t step_ = 0;
  double full_ms_ = 0;  // what the last frame would have taken at full size
};

}  // namespace ulf::render
