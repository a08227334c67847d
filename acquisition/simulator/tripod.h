// Moves a camera on a tripod before a turntable: it stands, looking at the subject, for one turn of the
// table, is then raised by a row, and so on over the cap's height and back. It may tremble.
//
// World frame metres, time in seconds from the start.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>

#include "acquisition/simulator/hand.h"
#include "core/geometry/angles.h"

namespace ulf::acquisition {

struct TripodOptions {
  Eigen::Vector3d subject_in_world = Eigen::Vector3d::Zero();
  Eigen::Vector3d up_in_world = Eigen::Vector3d::UnitZ();
  Eigen::Vector3d first_direction = -Eigen::Vector3d::UnitY();  // from the subject to the cap's middle, unit
  double distance_m = 1;
  double cap_elevation = Radians(40);
  double row_spacing = Radians(2.2);
  double speed = Radians(13);  // at which it is raised, per second
  double stands_s = 15;        // at each height
  double unsteady = 0;         // 1 trembles and drifts as a hand does (hand.h)
  std::uint64_t seed = 7;
};

class Tripod : public HandMotion {
 public:
  explicit Tripod(const TripodOptions& options);
  Rigid3 CamFromWorld(double time_s) const override;

  int Heights() const { return heights_; }
  // Returns the elevation, radians, above the first direction.
  double Elevation(double time_s) const;

 private:
  TripodOptions options_;
  int heights_;
  double raised_in_s_;
  std::array<Waves, 3> shifts_, turns_;
};

}  // namespace ulf::acquisition
