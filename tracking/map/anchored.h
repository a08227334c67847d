#pragma once

#include "core/geometry/rigid3.h"

namespace ulf::tracking {

// A pose relative to a keyframe, which later adjustment may move.
struct Anchored {
  int keyframe_id = -1;
  Rigid3 cam_from_keyframe;
  // Of the keyframe when this was said: a closed loop scales lengths, this pose's with them.
  double unit = 1;
};

}  // namespace ulf::tracking
