// Whatever moves a simulated camera: a plan (hand.h), or somebody who looks at what comes of it.
#pragma once

#include "core/geometry/rigid3.h"

namespace ulf::acquisition {

class HandMotion {
 public:
  virtual ~HandMotion() = default;
  // Smooth in time. World frame metres, seconds from the start. Moments may be asked for in any order, but
  // of somebody who reacts only up to a moment after the last that was shown.
  virtual Rigid3 CamFromWorld(double time_s) const = 0;
};

}  // namespace ulf::acquisition
