// Notices that the subject itself was moved: the map's points on it are no longer found where the camera's
// pose, which the rest of the map holds, says that they are.
//
// A point counts for as often as it was found before when it was looked for (its record), so that surfaces
// that are hard to see, and points that were always doubtful, blame nobody. Points inside the subject's
// sphere are set against all others over the better part of a second.
#pragma once

#include <deque>
#include <span>

#include "acquisition/light_field.h"
#include "tracking/tracker.h"

namespace ulf {

class SubjectWatch {
 public:
  // After every tracked frame. True from when the subject seems to have moved until Forget(): the map soon
  // has new points on it and no longer tells.
  bool Moved(double time_s, std::span<const ExpectedPoint> points, const Subject& subject);
  void Forget() { frames_.clear(), moved_ = false; }

 private:
  struct Tally {
    double time_s = 0;
    double expected_on = 0, found_on = 0;  // on the subject
    double expected_off = 0, found_off = 0;
  };
  std::deque<Tally> frames_;
  bool moved_ = false;
};

}  // namespace ulf
