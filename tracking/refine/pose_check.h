// Whether photographs show what their poses say: for sets by other programs, whose poses may belong to other photographs
// (another order, another run) or to another lens, and for a light field of which a view is suspected.
//
// Corners of neighbouring views are matched without the poses. Two neighbours of a view that agree about a corner
// (epipolar lines) put it into space, and the view must show it where its pose has it. Two views alone would not do:
// along the line between them a pose can be off by anything and the epipolar lines stay the same. How far off is too
// far follows from what the matches are off by in the whole set, from what each pose says of its own error, and from
// how much the place of the three views enlarges both.
//
// A view is contradicted when most of the pairs of neighbours that testify about it do, and another pose explains what
// they say. The worst view is taken first, and what it says of others counts no more: a wrong view condemns none of its
// neighbours.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/light_field/light_field.h"
#include "tracking/refine/refine_input.h"

namespace ulf::tracking {

// Guessed, except where a line says so.
struct PoseCheckOptions {
  int corners = 1200;            // a view, about
  int max_side_px = 1000;        // larger pictures are reduced
  std::size_t min_matches = 15;  // that three views share, or two where no third shows them
  // A corner that is off by more standard deviations contradicts: more misses wrong poses, less blames right ones
  // whose errors are those of the set, but larger than most (settled: docs/tracking_measured.md, "Views whose poses
  // their neighbours contradict").
  double most_sigmas = 4;
  // Of the picture's width: a set whose poses are usually off by more is wrong as a whole, and its views are measured
  // by this.
  double usual_share = 0.005;
  // Two neighbours tell nothing about a view in which their errors would be so many times as large.
  double most_enlarged = 4;
  // Share of the corners that another pose must explain before a pose is called wrong: else the matches are.
  double explained_share = 0.6;
  int elsewhere = 24;  // views that one is compared with that shows nothing of what is around it
  std::function<void(double share, const std::string& stage)> progress = {};
};

// A view whose neighbours' pictures contradict its pose. `view` and `by` are indices of the input.
struct ContradictedView {
  int view = 0;
  double error_px = 0;  // median, of its corners from where its neighbours put them; pixels of the photograph
  // From the recorded pose to the one that explains these corners; the move as a share of their distance (median).
  double turned_deg = 0, moved_share = 0;
  std::vector<int> by;  // the neighbours that say so
};

// A view that cannot be judged.
struct UntoldView {
  int view = 0;
  std::string why;
};

struct PoseCheck {
  std::vector<ContradictedView> contradicted;  // in order of view, as are the next
  std::vector<UntoldView> untold;
  int agree = 0;  // views whose neighbours confirm their poses
  // Median distance from the epipolar lines in most pairs of views that fit; pixels of the photographs.
  double error_px = 0;
  // The poses are wrong as a whole (IsPoor of all pairs), whatever the views' verdicts.
  bool fits_poorly = false;
  double fit_error_px = 0;      // of all pairs, as error_px
  bool looks_away = false;      // most of what the photographs show lies behind their cameras
  std::string convention = {};  // PoseConvention() of poses that fit poorly; empty: none
};

// Reads every photograph once; some 50 ms of processor time a view of 640 x 480.
PoseCheck CheckPoses(const RefineInput& input, const PoseCheckOptions& options = {});

// Of poses that fit poorly as a whole, in words; else empty.
std::string FitInWords(const PoseCheck& check);

// Of views that cannot be judged, in words; empty: there are none.
std::string UntoldInWords(const PoseCheck& check, const std::vector<std::string>& names);

// What is wrong with poses; empty where nothing is. `views`: those of the input.
std::vector<Finding> FindingsOf(const PoseCheck& check, const std::vector<View>& views);

}  // namespace ulf::tracking
