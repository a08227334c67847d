// Moves a camera on a tripod before a turntable: it stands, looking at the subject, for one turn of the
// table, is then raised by a row, and so on over the cap's height and back. It may tremble.
//
// World frame metres, time in seconds from the start.
#pragma once

#include <array>

#include "acquisition/simulator/hand.h"

namespace ulf::acquisition {

class Tripod : public HandMotion {
 public:
  // It uses the options' subject, directions, distance, elevation, rows, speed (at which it is raised) and
  // seed. `stands_s`: time at each height; `unsteady`: 1 trembles and drifts as a hand does.
  Tripod(const HandOptions& options, double stands_s, double unsteady);
  Rigid3 CamFromWorld(double time_s) const override;

  int Heights() const { return heights_; }
  // Returns the elevation, radians, above the first direction.
  double Elevation(double time_s) const;

 private:
  const HandOptions options_;
  const double stands_s_;
  const int heights_;
  const double raised_in_s_;
  std::array<Waves, 3> shifts_, turns_;
};

}  // namespace ulf::acquisition
