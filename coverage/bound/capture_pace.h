// Measures how fast a capture covers its cap (coverage_map.h), and predicts how long the rest takes.
//
// Only time of work counts. Signs of work are new views that cover area, and movements of the camera by more
// than a disc radius; more than 5 s between two signs are a pause, and are left out. The pace is that of the
// last minute of work; it is unknown before 8 s of work and four views' area, and while the last 20 s of work
// have covered less than one view's area.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <deque>
#include <optional>

namespace ulf::coverage {

// A Guide has one for each subject. Areas are solid angles, steradians.
class CapturePace {
 public:
  // Call it after every frame with the device's time, the covered area, the number of recorded views, and the
  // camera's direction from the subject as a unit vector (none: unknown). `disc_radius`: the angle around its
  // direction that a view covers, radians.
  void Update(double time_s, double covered_sr, std::size_t views,
              const std::optional<Eigen::Vector3d>& direction, double disc_radius);
  // Returns the seconds of work that it takes to cover `open_sr`; none when the pace is unknown.
  // `sr_per_view`: the area that a view newly covers on average.
  std::optional<double> SecondsFor(double open_sr, double sr_per_view) const;

 private:
  struct Worked {
    double work_s = 0, painted_sr = 0;  // so far; the area is what new views covered
  };
  double known_sr_ = 0;
  std::size_t known_views_ = 0;
  bool begun_ = false;
  double sign_s_ = 0;                       // when the last sign of work was seen
  std::optional<Eigen::Vector3d> sign_at_;  // the camera's direction at that sign
  Worked now_;
  std::deque<Worked> before_;  // at signs of work, the oldest first
};

}  // namespace ulf::coverage
