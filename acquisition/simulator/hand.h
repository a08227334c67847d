// Plans the motion of a hand that scans a subject: the camera pose as a function of time, continuously
// differentiable and determined by the seed.
//
// The hand starts in front of the subject, moves sideways so that a monocular tracker can initialise, then
// sweeps rows over a cap: azimuth +-H/2 and elevation +-V/2 about the first direction, and `margin` beyond,
// because the first direction of a capture is known only after it has begun. Later passes have rows shifted
// by half a spacing, then a quarter, and so on, so that they fill the gaps of earlier passes. The hand
// trembles and drifts, varies its distance, and sometimes looks away for about a second, during which its
// position stays the same. With a dolly it goes nearer and farther as it sweeps, again and again.
//
// World frame metres, time in seconds from the start. Cap angles are longitude and latitude about the first
// direction, with the scene's up straightened to be perpendicular to it.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "core/geometry/angles.h"
#include "core/geometry/rigid3.h"

namespace ulf::acquisition {

// The motion of a simulated camera: planned (Hand) or reacting to what is displayed.
class HandMotion {
 public:
  virtual ~HandMotion() = default;
  // Returns the pose at a time, smooth in time. World frame in metres, seconds from the start. Times may come
  // in any order; for a motion that reacts they may not lie far after the last displayed frame.
  virtual Rigid3 CamFromWorld(double time_s) const = 0;
};

// Sums of sines with random phases, for the tremor and drift of a simulated hand: smooth, bounded functions
// of time without a visible period.
class Waves {
 public:
  struct Wave {
    double height, frequency_hz, phase;
  };

  Waves() = default;
  // `count` sines with frequencies between `low_hz` and `high_hz`; their sum is at most `height`. The same
  // seed and stream give the same waves.
  Waves(std::uint64_t seed, int stream, int count, double low_hz, double high_hz, double height);

  void Add(const Waves& more);
  double At(double time_s) const;
  const std::vector<Wave>& parts() const { return parts_; }

 private:
  std::vector<Wave> parts_;
};

// Returns the pose of a camera that is turned in place, radians about its own axes.
Rigid3 Turned(const Rigid3& cam_from_world, double yaw, double pitch, double roll);

struct HandOptions {
  Eigen::Vector3d subject_in_world = Eigen::Vector3d::Zero();
  Eigen::Vector3d up_in_world = Eigen::Vector3d::UnitZ();
  Eigen::Vector3d first_direction = -Eigen::Vector3d::UnitY();  // from the subject to the camera, unit
  double distance_m = 1;
  double cap_azimuth = Radians(60);
  double cap_elevation = Radians(40);
  double row_spacing = Radians(2.2);
  double margin = Radians(3);
  double speed = Radians(13);  // of azimuth, per second, along a row
  double dolly = 1;            // the distance changes between 1 / dolly and dolly times distance_m, slowly
  bool looks_away = true;
  std::uint64_t seed = 7;
};

class Hand : public HandMotion {
 public:
  explicit Hand(const HandOptions& options);

  Rigid3 CamFromWorld(double time_s) const override;

  // Returns the direction from the subject towards the camera as (azimuth, elevation) about the first
  // direction, radians.
  Eigen::Vector2d CapAngles(const Eigen::Vector3d& center_in_world) const;

  // Returns the seconds after which the first pass over the cap is complete.
  double FirstPassEndS() const;
  // Returns true while the hand looks away from the subject.
  bool LooksAway(double time_s) const;
  const HandOptions& options() const { return options_; }

 private:
  struct Stop {
    double time_s;  // of the path, which pauses while looking away
    Eigen::Vector2d angles;
    Eigen::Vector2d integral;  // of the angles from the first stop to this one
  };
  struct Glance {
    double start_s, yaw, pitch;
  };

  void PlanPath();
  void PlanGlances();
  void AddStop(double seconds, const Eigen::Vector2d& angles);
  Eigen::Vector2d PathIntegral(double path_s) const;
  Eigen::Vector2d PathAngles(double path_s) const;
  double PathTime(double time_s) const;
  double GlanceShare(double time_s, const Glance& glance) const;

  HandOptions options_;
  Eigen::Vector3d forward_, side_,
      up_;  // of the cap: first direction, towards larger azimuth, larger elevation
  std::vector<Stop> stops_;
  std::vector<Glance> glances_;
  double first_pass_end_path_s_ = 0;
  std::vector<Waves> waves_;
};

}  // namespace ulf::acquisition
