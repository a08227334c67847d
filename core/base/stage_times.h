// Measures the CPU time that the tracking thread takes for one frame, stage by stage; mapping has a thread of
// its own and is not in it.
#pragma once

#include "core/base/host_time.h"

namespace ulf {

struct StageTimes {
  double pyramid_s = 0;         // grey picture, image pyramid, sharpness
  double features_s = 0;        // corners, orientations, descriptors
  double matching_s = 0;        // choosing map points, comparing the frame's descriptors with theirs
  double alignment_s = 0;       // aligning patches of map points to sub-pixel places
  double refinement_s = 0;      // refining the pose with a robust error
  double initialization_s = 0;  // while there is no map: two-view matching and geometry
  double relocalization_s = 0;  // after a loss: descriptor search and its verification
  double keyframe_s = 0;        // deciding on a keyframe and handing it over
};

// Adds the CPU time from its construction to its end, or to Stop(), to `*sum_s`; does nothing with null.
class StageTimer {
 public:
  explicit StageTimer(double* sum_s) : sum_s_(sum_s), start_s_(sum_s ? ThreadCpuSeconds() : 0) {}
  ~StageTimer() { Stop(); }
  StageTimer(const StageTimer&) = delete;
  StageTimer& operator=(const StageTimer&) = delete;
  void Stop() {
    if (sum_s_) *sum_s_ += ThreadCpuSeconds() - start_s_;
    sum_s_ = nullptr;
  }

 private:
  double* sum_s_;
  double start_s_;
};

}  // namespace ulf
