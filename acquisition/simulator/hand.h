// Plans the motion of a hand that scans a subject: the camera pose as a function of time, continuously
// differentiable and determined by the seed.
//
// The hand starts in front of the subject, moves sideways so that a monocular tracker can initialise, then
// sweeps rows of constant elevation over a cap: azimuth +-cap_azimuth/2 and elevation +-cap_elevation/2 about
// first_direction, and `margin` beyond, because a capture centres its cap on its first view, which lies only
// near first_direction. Later passes have rows shifted by half a spacing, then a quarter, and so on, so that
// they fill the gaps of earlier passes. The hand trembles and drifts, varies its distance, and sometimes
// looks away for about a second, during which the sweep pauses. With a dolly it also goes nearer and farther,
// again and again. After three hours the sweep ends.
//
// The world is in metres, times are in seconds from the start, angles in radians. Azimuth and elevation are 0
// in first_direction; azimuth grows to the right of a person who looks at the subject, elevation towards the
// part of up_in_world that is perpendicular to first_direction.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "core/geometry/angles.h"
#include "core/geometry/rigid3.h"

namespace ulf::acquisition {

// Moves a simulated camera, as planned (Hand) or in reaction to what is displayed.
class HandMotion {
 public:
  virtual ~HandMotion() = default;
  // Returns the pose, smooth in time. A planned motion takes times in any order. One that reacts takes
  // growing times, which may go back by a second at most; what is displayed later changes only later poses.
  virtual Rigid3 CamFromWorld(double time_s) const = 0;
};

// Sums sines with random phases, for the tremor and drift of a simulated hand: a smooth, bounded function of
// time without a visible period.
class Waves {
 public:
  struct Wave {
    double height, frequency_hz, phase;  // height: amplitude, in the unit of At(); phase: radians
  };

  Waves() = default;
  // Makes `count` sines with frequencies between `low_hz` and `high_hz`, each of amplitude `height` /
  // `count`. `stream` numbers the independent random sequences of a seed.
  Waves(std::uint64_t seed, int stream, int count, double low_hz, double high_hz, double height);

  void Add(const Waves& more);
  double At(double time_s) const;
  const std::vector<Wave>& parts() const { return parts_; }

 private:
  std::vector<Wave> parts_;
};

// Returns the pose of a camera that is turned in place about its own axes, radians: by yaw about y, then by
// pitch about x, then by roll about z.
Rigid3 Turned(const Rigid3& cam_from_world, double yaw, double pitch, double roll);

struct HandOptions {
  Eigen::Vector3d subject_in_world = Eigen::Vector3d::Zero();
  Eigen::Vector3d up_in_world = Eigen::Vector3d::UnitZ();
  // Unit vector from the subject to the camera, in the world; not parallel to up_in_world.
  Eigen::Vector3d first_direction = -Eigen::Vector3d::UnitY();
  double distance_m = 1;               // from the subject to the camera
  double cap_azimuth = Radians(60);    // whole width
  double cap_elevation = Radians(40);  // whole height
  double row_spacing = Radians(2.2);   // largest difference in elevation between rows of one pass
  double margin = Radians(3);          // beyond each side of the cap
  double speed = Radians(13);          // radians of azimuth per second along a row
  double dolly = 1;  // in 12 s the distance goes to distance_m / dolly, to distance_m * dolly, and back
  bool looks_away = true;
  std::uint64_t seed = 7;
};

class Hand : public HandMotion {
 public:
  explicit Hand(const HandOptions& options);

  Rigid3 CamFromWorld(double time_s) const override;

  // Returns the direction from the subject to a camera's centre as (azimuth, elevation), radians.
  Eigen::Vector2d CapAngles(const Eigen::Vector3d& center_in_world) const;

  // Returns the seconds after which the first pass over the cap is complete.
  double FirstPassEndS() const;
  // Returns true while the hand looks away from the subject.
  bool LooksAway(double time_s) const;
  const HandOptions& options() const { return options_; }

 private:
  struct Stop {
    double time_s;             // path time, which pauses while the hand looks away
    Eigen::Vector2d angles;    // azimuth, elevation
    Eigen::Vector2d integral;  // integral of the angles over path time from the first stop to this one
  };
  struct Glance {
    double start_s, yaw, pitch;  // largest yaw and pitch, radians
  };

  void PlanPath();
  void PlanGlances();
  void AddStop(double seconds, const Eigen::Vector2d& angles);
  Eigen::Vector2d PathIntegral(double path_s) const;
  Eigen::Vector2d PathAngles(double path_s) const;
  double PathTime(double time_s) const;
  double GlanceShare(double time_s, const Glance& glance) const;

  HandOptions options_;
  // Axes of the cap, unit vectors in the world: the first direction (from the subject to the camera), towards
  // larger azimuth, towards larger elevation.
  Eigen::Vector3d forward_, side_, up_;
  std::vector<Stop> stops_;
  std::vector<Glance> glances_;
  double first_pass_end_path_s_ = 0;
  std::vector<Waves> waves_;
};

}  // namespace ulf::acquisition
