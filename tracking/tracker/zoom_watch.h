// Detects a zoom that is moved during tracking, by each frame's focal length against the map's
// (focal_change.h).
//
// A growing map adopts what a moved zoom shows and soon agrees with it. So a frame that disagrees becomes no
// keyframe. If frames continue to disagree the zoom counts as moved, and the focal length with which frames
// are tracked follows it until it is back, so that poses stay right. A map that a wrong lens has bent
// disagrees a little all the time: what counts is the difference from the frames before.
#pragma once

#include <deque>
#include <optional>

#include "tracking/estimation/focal_change.h"

namespace ulf::tracking {

class ZoomWatch {
 public:
  // Call it after each frame that has a pose. `change` is the frame's focal length over that with which it
  // was tracked; none: unknown. `other` is one standard deviation, also of a logarithm, of what may look like
  // a zoom: an error of the map or a rolling shutter.
  void Step(double time_s, const std::optional<FocalChange>& change, double other);
  // Returns whether the last frame should not become a keyframe.
  bool Disagrees() const { return since_disagreed_ < kLastFrames || IsMoved(); }
  bool IsMoved() const { return log_ratio_ != 0; }
  // Returns the logarithm of the focal length for tracking frames over the lens's; 0: it is not moved.
  double log_ratio() const { return log_ratio_; }
  void Forget();  // call it when the map or the lens is replaced

 private:
  struct Frame {
    double time_s, log_ratio;
  };
  static constexpr std::size_t kLastFrames = 8;  // whose median is compared with the frames before. Guessed
  static constexpr std::size_t kLongAgo = 1000;
  void Follow(double difference, double noise);

  std::deque<Frame> before_;  // with the lens's focal length, the last ones at the end
  double usual_ = 0;          // while the zoom is moved: the median before it was
  double log_ratio_ = 0;
  std::size_t since_disagreed_ = kLongAgo;  // frames
};

}  // namespace ulf::tracking
