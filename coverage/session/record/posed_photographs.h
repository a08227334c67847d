// Decides which frames become posed photographs when there is no subject: those that show something that no
// recorded view shows yet, judged by parallax and overlap; among neighbouring frames the sharpest.
//
// A recorded view shows the same as a frame if it contains most of the frame's tracked points, seen from
// nearly the same direction. All recorded views are compared, not only the last: a place that is visited
// twice is recorded once.
#pragma once

#include <optional>
#include <vector>

#include "core/frames/frame.h"
#include "core/geometry/camera_model.h"
#include "coverage/bound/view_decision.h"
#include "coverage/session/record/recorded_views.h"
#include "tracking/tracker/track.h"

namespace ulf::coverage {

struct PhotographSpacing {
  double parallax_deg = 1;     // median over the points; a frame with more is another view
  double least_overlap = 0.6;  // share of the points in the recorded view's picture; so is one with less
};

// A frame that may be recorded, held until its neighbours have been compared.
struct HeldFrame {
  Frame frame;
  tracking::Track track;
  double depth = 1;  // median depth of the tracked points, world units
};

class PosedPhotographs {
 public:
  explicit PosedPhotographs(const PhotographSpacing& spacing) : spacing_(spacing) {}

  // Describes what is to be done about a frame.
  struct Step {
    Decision decision;       // of this frame; kRecorded: it is to be held
    bool located = false;    // this frame's pose is known, by points enough
    bool ends_held = false;  // the frame that is held has had its neighbours, and is to be recorded
    bool replaces = false;   // the frame that is held is less sharp and is to be dropped
    double depth = 1;        // HeldFrame::depth of this frame
  };
  // Decides about a frame without changing anything.
  Step Decide(const FrameToDecide& input, const std::vector<tracking::VisiblePoint>& points,
              const RecordedViews& views) const;
  // Carries out Decide()'s step for the same frame. Returns the frame that is to be recorded, the sharpest
  // among its neighbours; none: nothing is to be recorded now.
  std::optional<HeldFrame> Take(const Step& step, const FrameToDecide& input);
  // Returns at the end the frame that is still held.
  std::optional<HeldFrame> TakeHeld();

 private:
  // `about_to_be_recorded` counts like one of `views`; null: none.
  Decision Judge(const FrameToDecide& input, const std::vector<tracking::VisiblePoint>& sample,
                 const RecordedViews& views, const HeldFrame* about_to_be_recorded) const;
  bool IsLocated(const FrameToDecide& input, const std::vector<tracking::VisiblePoint>& points) const;
  bool IsNeighbour(const FrameToDecide& input, const std::vector<tracking::VisiblePoint>& points) const;

  const PhotographSpacing spacing_;
  std::optional<HeldFrame> held_;
  std::optional<Rigid3> first_;  // where the first of the neighbours stood
  int neighbours_ = 0;
};

}  // namespace ulf::coverage
