// Detects that the subject itself was moved: the map points on it are no longer found where the camera's pose,
// which rests on the other points, predicts them. An object in front of the subject looks the same until the
// points are found again.
//
// Each point is weighted by its find rate, so that points which were always hard to find do not count as
// missing. Points inside the subject's sphere are compared with all others.
#pragma once

#include <deque>
#include <optional>
#include <span>

#include "core/light_field/light_field.h"
#include "tracking/tracker/tracker.h"

namespace ulf::coverage {

class SubjectWatch {
 public:
  // Tried with a simulated subject that is moved and with hands before one that is not
  // (tests/coverage/session/capture_checks_test); otherwise guessed.
  struct Options {
    double over_s = 0.3;  // frames that are taken together
    // Of what their record promises, the subject's points against the others: below the first they are gone,
    // above the second there again.
    double gone_share = 0.45, there_share = 0.8;
    double stays_gone_s = 0.5;  // so long they have to be gone: a hand passes before the subject
    // Frames that a point has to be known for, and since before they were gone: what a subject that has moved
    // shows soon becomes points of its own, which would speak for it.
    int known_for_frames = 20;
    double fewest_per_frame = 8;  // points that should have been found; fewer say nothing
    std::size_t fewest_frames = 3;
    double rest_share = 0.5;  // where less of the rest is found it is the tracker that is in trouble
  };
  SubjectWatch() = default;
  explicit SubjectWatch(const Options& options) : options_(options) {}

  // After every tracked frame.
  bool Moved(double time_s, std::span<const tracking::ExpectedPoint> points, const Subject& subject);
  void Reset();

 private:
  struct Tally {
    double time_s = 0;
    double expected_on = 0, found_on = 0;  // on the subject
    double expected_off = 0, found_off = 0;
  };
  // On the subject against off it; none where too little is expected to tell.
  std::optional<double> ShareFound() const;

  Options options_;
  std::deque<Tally> frames_;
  std::optional<double> gone_since_s_;
  int frames_gone_ = 0;  // since then
};

}  // namespace ulf::coverage
