// Whether photographs show what their poses say: for sets by other programs, whose poses may belong to other photographs
// (another order, another run) or to another lens.
//
// Corners of neighbouring views are matched without the poses. Where the poses of three views are right, most corners
// that all three show are where the other two put them; where one of the poses belongs to another photograph, hardly
// any is. (Epipolar lines of two views alone do not tell photographs of a straight way apart: the lines stay the same.)
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tracking/refine/refine.h"

namespace ulf::tracking {

// Guessed.
struct PoseCheckOptions {
  int corners = 1200;            // a view, about
  int max_side_px = 1000;        // larger pictures are reduced
  int pairs_per_view = 4;        // with neighbours in different directions
  std::size_t min_matches = 15;  // that three views share, or two where no third shows them
  // A match fits within this share of the picture's width, three views agree by this share of their matches. Measured
  // on two real sets: the best three around a view agree by 0.9 to 1; around a wrong one of a simulated set by 0.5.
  double near_share = 0.005, agreeing_share = 0.6;
  std::function<void(double share, const std::string& stage)> progress = {};
};

struct PoseCheck {
  std::vector<int>
      disagree;         // views, by index, that share enough with neighbours and agree with none of them
  int agree = 0;        // views that agree with one
  int untold = 0;       // views that share too little with their neighbours
  double error_px = 0;  // median distance from the epipolar lines, pixels of the photographs
  std::vector<std::string> unread;  // why
};

PoseCheck CheckPoses(const RefineInput& input, const PoseCheckOptions& options = {});

// In words, for people: empty where nothing is to be said. `names`: of the views.
std::string InWords(const PoseCheck& check, const std::vector<std::string>& names);

}  // namespace ulf::tracking
