// Notices that the subject itself was moved: the map's points on it are no longer found where the camera's
// pose, which the rest of the map holds, says that they are, and stay so. Something that comes to stand
// before the subject looks the same; it is over when the points are found again.
//
// A point counts for as often as it was found before when it was looked for (its record), so that surfaces
// that are hard to see, and points that were always doubtful, blame nobody. Points inside the subject's
// sphere are set against all others.
#pragma once

#include <deque>
#include <optional>
#include <span>

#include "core/light_field/light_field.h"
#include "tracking/tracker/tracker.h"

namespace ulf::coverage {

class SubjectWatch {
 public:
  // After every tracked frame.
  bool Moved(double time_s, std::span<const tracking::ExpectedPoint> points, const Subject& subject);
  void Forget();

 private:
  struct Tally {
    double time_s = 0;
    double expected_on = 0, found_on = 0;  // on the subject
    double expected_off = 0, found_off = 0;
  };
  // On the subject against off it; none where too little is expected to tell.
  std::optional<double> ShareFound() const;

  std::deque<Tally> frames_;
  std::optional<double> gone_since_s_;
  int frames_gone_ = 0;  // since then
};

}  // namespace ulf::coverage
