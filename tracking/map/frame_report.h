// Defines what the tracker reports to the mapper about a frame.
#pragma once

#include <optional>
#include <vector>

#include "tracking/estimation/rolling_shutter.h"
#include "tracking/map/map.h"

namespace ulf::tracking {

// A frame that should become a keyframe, with the points that it saw. The observations name no keyframe yet.
struct NewKeyframe {
  Keyframe keyframe;
  // Joins of parts of the map until the pose was found: a later join has moved the pose's world.
  int joins = 0;
  struct Seen {
    int point;
    Observation observation;
  };
  std::vector<Seen> seen;
};

struct FrameReport {
  std::vector<int> expected = {};  // points that the frame's pose should show
  std::vector<int> found = {};     // points that support the pose
  // The velocity of an earlier keyframe from the frames before and after it: a central difference, unbiased
  // by tremor. The mapper drops it when that keyframe is not in the map yet.
  struct KeyframeVelocity {
    double time_s = 0;  // of the keyframe
    Twist velocity = Twist::Zero();
  };
  std::optional<KeyframeVelocity> velocity = {};
  std::optional<NewKeyframe> keyframe = {};
};

}  // namespace ulf::tracking
