// How fast a capture covers its cap, and so how long the rest takes.
//
// Time counts while the hand works: while it paints, or goes on to where it will paint. When it rests, or the
// pose is lost, the clock stands, and with it what is expected: a pause is no slower pace. The pace is that
// of the last minute of work. A hand that works on and paints no more has no pace that would tell anything.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <deque>
#include <optional>

namespace ulf::coverage {

class CapturePace {
 public:
  // Guessed; what they come to with simulated people: docs/capture.md#guidance.
  struct Options {
    double least_s = 8;      // not over less,
    double least_views = 4;  // nor over less area than so many views paint
  };
  // After every frame: the area that is covered, the number of views, and the direction in which the camera
  // stands (none: it is not known). `disc_radius`: what a view covers around it, radians.
  void At(double time_s, double covered_sr, std::size_t views,
          const std::optional<Eigen::Vector3d>& direction, double disc_radius);
  // For this area; none: nobody can tell yet, or any more. `sr_per_view`: that a view paints.
  std::optional<double> SecondsFor(double open_sr, double sr_per_view) const;

 private:
  struct Worked {
    double work_s = 0, painted_sr = 0;  // so far
  };
  Options options_;
  double known_sr_ = 0;
  std::size_t known_views_ = 0;
  bool begun_ = false;
  double sign_s_ = 0;                       // when the last sign of work was seen
  std::optional<Eigen::Vector3d> sign_at_;  // and where the camera stood then
  Worked now_;
  std::deque<Worked> before_;  // at signs of work, the oldest first
};

}  // namespace ulf::coverage
