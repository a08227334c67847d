// Detects a hunting autofocus: pictures of the same things that are sharp, soft, and sharp again.
//
// It compares the fine detail at points that are tracked from picture to picture (picture_tracks.h). Detail
// is measured perpendicular to the motion, so that neither the scene nor motion blur counts. A shaking hand
// blurs single pictures, a moving focus all of them: the sharpest picture of the last 0.4 s decides.
#pragma once

#include <deque>
#include <optional>

#include "coverage/session/watch/picture_tracks.h"

namespace ulf::coverage {

class FocusWatch {
 public:
  // A pair with few points, or that does not begin with the last one's second picture, restarts the watch.
  void Update(const PicturePair& pair);
  // Returns the largest ratio so far of the sharpest picture's fine detail to the softest one's while the
  // focus hunts (at least four swings within 8 s); none if it never did. A restart keeps it.
  std::optional<double> HuntingAmplitude() const { return hunts_; }
  // Returns the time of the last swing while the focus hunted, by PicturePair's clock; 0 if it never did.
  double LastSwingS() const { return last_swing_s_; }

 private:
  struct Moment {
    double time_s = 0, log_detail = 0;  // log_detail: natural logarithm, 0 at the last restart
  };
  std::deque<Moment> moments_;       // of the last 0.4 s
  double highest_ = 0, lowest_ = 0;  // log_detail since the last swing
  int direction_ = 0;                // the last swing's: 1 sharper, -1 softer, 0 none yet
  std::deque<Moment> swings_;        // of the last 8 s: when each was seen, and log_detail where it began
  std::optional<double> hunts_;
  double last_swing_s_ = 0;
};

}  // namespace ulf::coverage
