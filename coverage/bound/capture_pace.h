// Measures how fast a capture covers its cap, and predicts from that how long the rest takes.
//
// Only time of work counts: while new area is covered, or the camera moves to where area will be. While it
// rests, or the pose is lost, the clock stands, so that a pause is no slower pace. The pace is that of the
// last minute of work; without newly covered area there is none.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <deque>
#include <optional>

namespace ulf::coverage {

class CapturePace {
 public:
  // Call it after every frame with the covered area, the number of views, and the camera's direction from the
  // subject (none: unknown). `disc_radius`: what a view covers around it, radians.
  void Update(double time_s, double covered_sr, std::size_t views,
              const std::optional<Eigen::Vector3d>& direction, double disc_radius);
  // Returns the time for this area; none when there is no pace yet, or no longer. `sr_per_view`: the area
  // that a view covers.
  std::optional<double> SecondsFor(double open_sr, double sr_per_view) const;

 private:
  struct Worked {
    double work_s = 0, painted_sr = 0;  // so far
  };
  double known_sr_ = 0;
  std::size_t known_views_ = 0;
  bool begun_ = false;
  double sign_s_ = 0;                       // when the last sign of work was seen
  std::optional<Eigen::Vector3d> sign_at_;  // and where the camera stood then
  Worked now_;
  std::deque<Worked> before_;  // at signs of work, the oldest first
};

}  // namespace ulf::coverage
