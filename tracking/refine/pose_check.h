// Checks whether photographs show what their poses say: for sets by other programs, whose poses may belong to
// other photographs (another order, another run) or to another lens, and for a light field of which a view is
// suspected.
//
// Corners of neighbouring views are matched without the poses. Where two neighbours of a view agree about a
// corner (epipolar lines), it is triangulated from them and transferred into the view, which must show it
// there (an outlier test with three views). Two views do not suffice: a pose that is off along the line
// between them leaves the epipolar lines the same. The threshold follows from the matches' errors in the
// whole set, from what each pose says of its own error, and from how much the geometry of the three views
// enlarges both.
//
// A view is an outlier when most of the tests about it contradict its pose, and another pose, fitted to the
// same corners, explains them (a refit by consensus). The worst view is removed first, and it takes no part
// in tests of others any more, so that a wrong view condemns none of its neighbours.
//
// Errors are pixels of the photographs, angles degrees; poses are cam_from_world in the input's units.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/light_field/light_field.h"
#include "tracking/refine/refine_input.h"

namespace ulf::tracking {

// A view whose neighbours' pictures contradict its pose. `view` and `by` are indices of the input.
struct ContradictedView {
  int view = 0;
  // The median distance of its corners from where the neighbours' points project; pixels of the photograph.
  double error_px = 0;
  // The change from the recorded pose to the one that explains these corners; the move as a share of their
  // distance (median).
  double turned_deg = 0, moved_share = 0;
  std::vector<int> by;  // the neighbours whose tests contradict the pose
};

// A view whose pose can neither be confirmed nor contradicted.
struct UndecidedView {
  int view = 0;
  std::string why;
};

struct PoseCheck {
  std::vector<ContradictedView> contradicted;  // in order of view, as are the next
  std::vector<UndecidedView> undecided;
  int agree = 0;  // views whose neighbours confirm their poses
  // Median distance from the epipolar lines in most pairs of views that fit; pixels of the photographs.
  double error_px = 0;
  // The poses are wrong as a whole (IsPoor() of all pairs), whatever the tests of single views say.
  bool fits_poorly = false;
  double fit_error_px = 0;      // the same as error_px for all pairs
  bool looks_away = false;      // most of what the photographs show lies behind their cameras
  std::string convention = {};  // PoseConvention() of poses that fit poorly; empty: none
};

// Reads every photograph once; takes some 50 ms of processor time for a view of 640 x 480.
PoseCheck CheckPoses(const RefineInput& input,
                     const std::function<void(double share, const std::string& stage)>& progress = {});

// Returns a sentence when the poses fit poorly as a whole; empty where they do not.
std::string FitInWords(const PoseCheck& check);

// Returns a sentence that names the undecided views; empty where there are none.
std::string UndecidedInWords(const PoseCheck& check, const std::vector<std::string>& names);

// Returns the findings about the poses, empty where nothing is wrong. `views`: the views of the input.
std::vector<Finding> FindingsOf(const PoseCheck& check, const std::vector<View>& views);

}  // namespace ulf::tracking
