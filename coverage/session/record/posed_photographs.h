// Which frames of a walk become photographs when there is no subject to go round: those that show what no
// recorded view does, by parallax and overlap; of neighbouring ones the sharpest.
//
// A recorded view stands for a frame while most of the points that the frame shows are in its picture, seen
// from nearly the same direction. Every recorded view is asked, not only the last: who comes back to a place
// records it once.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "core/geometry/camera_model.h"
#include "core/image/frame.h"
#include "coverage/bound/view_decision.h"
#include "coverage/session/record/held_views.h"
#include "tracking/sources/pose_source.h"

namespace ulf::coverage {

struct PhotographSpacing {
  double parallax_deg = 1;     // median over the points; more is another view
  double least_overlap = 0.6;  // share of the points that the recorded view has in its picture; less is
};

// The median depth of what is tracked; none where too little is.
std::optional<double> MedianDepth(const std::vector<tracking::VisiblePoint>& points);

// Whether a view at `before_from_world` stands for the frame that shows `points` from `cam_from_world`.
bool StandsFor(const Rigid3& before_from_world, const Rigid3& cam_from_world, const CameraModel& camera,
               const std::vector<tracking::VisiblePoint>& points, const PhotographSpacing& spacing);

// A frame that may be recorded, held until its neighbours have been looked at.
struct HeldFrame {
  Frame frame;
  tracking::Track track;
  double depth = 1;  // median, of what was tracked in it
};

class PosedPhotographs {
 public:
  PosedPhotographs(const CameraModel& camera, const PhotographSpacing& spacing)
      : camera_(camera), spacing_(spacing) {}

  struct Step {
    Decision decision;                // of this frame; kRecorded: it is the one that is held
    std::optional<HeldFrame> record;  // a frame whose neighbours have all been seen
    bool replaced = false;            // the one that was held is not as sharp: it will not be recorded
  };
  // Of a frame that is not to be held: kRecorded where it would be wanted.
  Decision Judge(const FrameToDecide& input, const std::vector<tracking::VisiblePoint>& points,
                 const HeldViews& views, const DecisionLimits& limits) const;
  Step After(const FrameToDecide& input, const std::vector<tracking::VisiblePoint>& points,
             const HeldViews& views, const DecisionLimits& limits);
  // What is held, at the end.
  std::optional<HeldFrame> TakeHeld();

 private:
  Decision Judge(const FrameToDecide& input, const std::vector<tracking::VisiblePoint>& some_points,
                 const HeldViews& views, const HeldFrame* besides, const DecisionLimits& limits) const;
  bool IsANeighbour(const FrameToDecide& input, const std::vector<tracking::VisiblePoint>& points) const;

  const CameraModel camera_;
  const PhotographSpacing spacing_;
  std::optional<HeldFrame> held_;
  std::optional<Rigid3> first_;  // where the first of the neighbours stood
  int neighbours_ = 0;
};

}  // namespace ulf::coverage
