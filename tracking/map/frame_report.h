// Defines what the tracker reports to the mapper about a frame.
#pragma once

#include <optional>
#include <vector>

#include "tracking/estimation/rolling_shutter.h"
#include "tracking/map/map.h"

namespace ulf::tracking {

// A frame that should become a keyframe, with the map points that it saw.
struct NewKeyframe {
  Keyframe keyframe;
  // SharedMap::joins when the pose was found. The mapper drops the frame after another join.
  int joins = 0;
  struct Seen {
    int point;                // MapPoint::id
    Observation observation;  // its `keyframe` is not set yet
  };
  std::vector<Seen> seen;
};

struct FrameReport {
  std::vector<int> expected = {};  // ids of points that the frame's pose should show
  std::vector<int> found = {};     // ids of points that support the frame's pose
  // The velocity of the newest keyframe from the frames before and after it: a central difference, unbiased
  // by tremor. The mapper drops it if that keyframe is not in the map yet.
  struct KeyframeVelocity {
    double time_s = 0;  // of the keyframe
    Twist velocity = Twist::Zero();
  };
  std::optional<KeyframeVelocity> velocity = {};
  std::optional<NewKeyframe> keyframe = {};
};

}  // namespace ulf::tracking
