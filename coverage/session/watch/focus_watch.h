// Detects a hunting autofocus: pictures of the same things that are sharp, soft, and sharp again.
//
// It compares points that are tracked from picture to picture (picture_tracks.h), across the motion, so that
// neither the scene nor the motion counts. A shaking hand blurs single pictures, a moving focus all of them:
// the sharpest of some neighbouring pictures decide.
#pragma once

#include <deque>
#include <optional>

#include "coverage/session/watch/picture_tracks.h"

namespace ulf::coverage {

class FocusWatch {
 public:
  // A pair that does not continue the last one restarts the watch.
  void Update(const PicturePair& pair);
  // Returns the amplitude: the sharpest picture's fine detail over the softest one's; none when the focus
  // does not hunt.
  std::optional<double> HuntingAmplitude() const { return hunts_; }
  // Returns when a swing was last seen.
  double LastSwingS() const { return last_swing_s_; }

 private:
  struct Moment {
    double time_s = 0, log_detail = 0;
  };
  std::deque<Moment> moments_;       // of late
  double highest_ = 0, lowest_ = 0;  // since the last swing
  int direction_ = 0;                // of the last swing; 0: none yet
  std::deque<Moment> swings_;        // their ends
  std::optional<double> hunts_;
  double last_swing_s_ = 0;
};

}  // namespace ulf::coverage
