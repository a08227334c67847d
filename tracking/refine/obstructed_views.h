// Finds views before whose lens something stood that no other view shows: a hand, somebody who walked
// through.
//
// Corners that two neighbours of a view match, and about which their epipolar lines agree, are triangulated
// and projected into the view. It confirms a corner if it shows about there a corner with the same
// descriptor, or a patch that looks as the neighbour's does when the poses warp it. Brightness and contrast
// are free, so shadows and exposures do not matter. A view is obstructed if it confirms hardly any corner in
// a large part of its picture and shows hardly any there with which a neighbour agrees (otherwise the scene
// itself hides them), and confirms them as usual elsewhere: a blurred view or one of a wrong pose confirms
// none.
//
// Limits: where neighbours show nothing that can be matched, nothing is judged; what neighbours see from more
// than some 25 degrees away is not compared.
#pragma once

#include <functional>
#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "core/light_field/light_field.h"
#include "tracking/refine/refine_scene.h"
#include "tracking/refine/view_pairs.h"

namespace ulf::tracking {

struct ObstructedView {
  int view = 0;               // index into the scene's views
  double without_share = 0;   // share of the picture in which no corner of its neighbours is confirmed
  double agreeing_share = 0;  // share of the picture in which they are; the rest is not judged
};

// `pairs` are those of neighbouring views; `sigma_px` has one standard deviation of where each view shows a
// corner of the others by its pose. Views with `takes_part` false (wrong poses) are neither judged nor asked.
// `read_mask` is RefineInput's. By ascending view.
std::vector<ObstructedView> FindObstructedViews(const RefineScene& scene,
                                                const std::vector<UnguidedPair>& pairs,
                                                std::span<const double> sigma_px,
                                                const std::vector<bool>& takes_part,
                                                const std::function<cv::Mat(int view)>& read_mask);

// Returns the finding about them; none if there are none. `views` are those of the scene.
std::vector<Finding> FindingsOf(std::span<const ObstructedView> obstructed, const std::vector<View>& views);

}  // namespace ulf::tracking
