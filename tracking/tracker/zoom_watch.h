// Notices a zoom that is moved while the camera is followed, by each frame's focal length against the map's
// (focal_change.h).
//
// A map that grows takes in what a moved zoom shows, and soon agrees with it: so a frame that disagrees is no keyframe.
// Where such frames go on to disagree the zoom is moved, and the frames' focal length follows it, so that poses stay
// right, until the zoom is back. A map that a wrong lens has bent disagrees a little all the time: what counts is the
// difference from the frames before.
#pragma once

#include <deque>
#include <optional>

#include "tracking/estimation/focal_change.h"

namespace ulf::tracking {

// Logarithms of the focal length: 0.01 is 1 %. Measured on recordings and simulated scenes with right lenses, with lenses
// 5 and 15 % off, and with rolling shutters that turn fast (docs/tracking_measured.md, "A zoom that is moved").
struct ZoomWatchOptions {
  // A frame that differs by more is no keyframe, nor are those that follow it closely; by so many times the size of the
  // differences before, where a map disagrees all the time.
  double suspicious = 0.006, suspicious_times = 2.5;
  // The zoom is moved where the last frames differ by more in the median.
  double moved = 0.01, moved_times = 4;
  double back = 0.005;  // it is back where the focal length followed differs by less
  // A smaller difference may be chance, or what neighbouring points and the map are off by together; of a moved zoom, once
  // it is known, chance alone counts.
  double sigmas = 10, other_sigmas = 5, followed_sigmas = 2;
  double uncertain = 0.0015;  // a frame that leaves more open, before a wall, counts less by as much
  std::size_t last_frames = 8;
  double before_s = 2;  // against the median of the frames of so long before them, and at least so many
  std::size_t fewest_before = 15;
};

class ZoomWatch {
 public:
  explicit ZoomWatch(const ZoomWatchOptions& options = {}) : options_(options) {}

  // After each frame that has a pose. `change`: from the focal length with which the frame was followed; none: unknown.
  // `other`: one standard deviation of what else may look like it, a map that is off or rows that roll.
  void Step(double time_s, const std::optional<FocalChange>& change, double other);
  // The last frame should not become a keyframe.
  bool Disagrees() const { return since_disagreed_ < options_.last_frames || IsMoved(); }
  bool IsMoved() const { return log_ratio_ != 0; }
  // Of the focal length with which frames are to be followed over the lens's; 0: the lens's own.
  double log_ratio() const { return log_ratio_; }
  void Forget();  // another map, or another lens

 private:
  struct Frame {
    double time_s, log_ratio;
  };
  static constexpr std::size_t kLongAgo = 1000;
  void Follow(double difference, double noise);

  ZoomWatchOptions options_;
  std::deque<Frame> before_;  // with the lens's focal length, the last ones at the end
  double usual_ = 0;          // while the zoom is moved: the median before it was
  double log_ratio_ = 0;
  std::size_t since_disagreed_ = kLongAgo;  // frames
};

}  // namespace ulf::tracking
