// The motion of a simulated camera: planned (hand.h) or reacting to what is displayed.
#pragma once

#include "core/geometry/rigid3.h"

namespace ulf::acquisition {

class HandMotion {
 public:
  virtual ~HandMotion() = default;
  // The pose at a time, smooth in time. World frame in metres, seconds from the start. Times may come in any
  // order; for a motion that reacts they may not lie far after the last displayed frame.
  virtual Rigid3 CamFromWorld(double time_s) const = 0;
};

}  // namespace ulf::acquisition
