// Runs a capture without pictures: the simulated operator, the coverage map, the decision and guidance are as
// in a real one, the tracker and the camera are left out. A minute of capture takes a second, so that many
// can be compared. The operator sees a world of arbitrary scale and orientation, as a tracker makes one;
// poses are exact in it, lost while the subject is far from the middle of the view, and found a little later.
#pragma once

#include <optional>

#include "coverage/bound/coverage_map.h"
#include "coverage/simulated_operator/simulated_operator.h"
#include "tests/support/floors.h"

namespace ulf::test {

struct ImaginedCapture {
  OperatorOptions person;
  double threshold_px = 7;
  std::optional<Cap> cap = Cap{60 * M_PI / 180, 40 * M_PI / 180};
  double until_share = 0.95;
  double subject_size = 0.28;  // width of the sphere's image, share of the picture's width
  double fps = 15;
  double exposure_s = 0.005;
  double max_seconds = 600;
};

struct ImaginedResult {
  std::size_t views = 0;
  double seconds = 0;                                   // until covered, or to the end
  double covered = 0;                                   // share of the cap, by the map; 0 without a cap
  double disc_radius = 0;                               // radians
  double lost_share = 0;                                // of the frames after the first that was tracked
  double way = 0;                                       // of the camera's direction from the subject, radians
  double ms_guidance_median = 0, ms_guidance_most = 0;  // processor time for a frame
  std::vector<CriterionView> recorded;
  Subject subject;
  Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
  // Returns the least number of discs of that radius that cover the cap, by the hexagonal lattice.
  double LeastViews(const Cap& cap) const;
};

ImaginedResult RunImagined(const ImaginedCapture& capture);

}  // namespace ulf::test
