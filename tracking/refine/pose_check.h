// Checks whether photographs show what their poses say: for sets by other programs, whose poses may belong to
// other photographs (another order, another run) or to another lens, and for doubtful views.
//
// Corners of neighbouring views are matched without the poses. A corner about which two neighbours of a view
// agree (epipolar lines) is triangulated from them and projected into the view, which must show it there (an
// outlier test with three views). Two views do not suffice: a pose that is off along the line between them
// leaves the epipolar lines the same. The threshold follows from the matches' errors in the whole set, from
// the error that is predicted for each pose, and from how much the geometry of the three views enlarges both.
//
// A view is contradicted if most of its tests contradict its pose, and another pose, fitted to the same
// corners by consensus, explains them. The worst view is removed first and takes no part in tests of others
// any more, so that a wrong view condemns none of its neighbours. Of the others, those are named before which
// something stood (obstructed_views.h).
//
// Errors are pixels of the photographs, angles degrees; poses are cam_from_world in the input's units.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/light_field/light_field.h"
#include "tracking/refine/obstructed_views.h"
#include "tracking/refine/refine_input.h"

namespace ulf::tracking {

// A view whose neighbours' pictures contradict its pose. `view` and `by` are indices of the input.
struct ContradictedView {
  int view = 0;
  double error_px = 0;  // median distance of its corners from where the neighbours' points project
  // The change from the given pose to the one that explains these corners; the move over their distance.
  double turned_deg = 0, moved_share = 0;
  std::vector<int> by;  // the neighbours whose tests contradict the pose
};

// A view whose pose can neither be confirmed nor contradicted.
struct UndecidedView {
  int view = 0;
  std::string why;
};

struct PoseCheck {
  std::vector<ContradictedView> contradicted;  // by ascending index, as `undecided`
  std::vector<UndecidedView> undecided;
  std::vector<ObstructedView> obstructed;  // whatever their poses; none where the poses fit poorly
  int agree = 0;                           // number of views whose neighbours confirm their poses
  double error_px = 0;  // median over the pairs of views that fit of the median distance from epipolar lines
  // The poses are wrong as a whole (IsPoor() of all pairs), whatever the tests of single views say.
  bool fits_poorly = false;
  double fit_error_px = 0;      // the same as `error_px` for all pairs
  bool is_repetitive = false;   // poses that fit poorly may be right (repetitions.h)
  double repeated_share = 0;    // of the matches: a corner looks like another place of the same picture
  bool looks_away = false;      // by the poses, most of what the photographs show lies behind their cameras
  std::string convention = {};  // PoseConvention() of poses that fit poorly; empty: none
};

// Reads every photograph once; an unreadable one is undecided. Takes some 50 ms for a view of 640 x 480.
PoseCheck CheckPoses(const RefineInput& input,
                     const std::function<void(double share, const std::string& stage)>& progress = {});

// Returns a sentence if the poses fit poorly as a whole, else "".
std::string FitInWords(const PoseCheck& check);

// Returns a sentence that names some of the undecided views, or "". `names` are those of all views.
std::string UndecidedInWords(const PoseCheck& check, const std::vector<std::string>& names);

// Returns the findings about the poses; none if nothing is wrong. `views` are those of the input.
std::vector<Finding> FindingsOf(const PoseCheck& check, const std::vector<View>& views);

}  // namespace ulf::tracking
