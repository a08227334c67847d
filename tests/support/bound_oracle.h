// Computes the coverage bound (criterion.h) by brute force, straight from its definition: for pixels of the
// recorded view that see the sphere, it follows rays in space around the circle of one pixel, projects the
// points where they enter and leave the sphere into the candidate, and takes the longest distance between any
// two. It uses no epipolar plane and no closed form, and is slow.
#pragma once

#include "coverage/bound/criterion.h"
#include "tests/support/floors.h"

namespace ulf::test {

struct BoundOracleOptions {
  int cone_rays = 48;         // around a pixel's circle
  int rings = 12;             // pixels tried: rings about the sphere's centre ...
  int pixels_on_a_ring = 24;  // ... times pixels on each
  bool refine = true;         // search on from the worst of them, down to a hundredth of a pixel
};

// Returns the error of the pixel at `img` of the recorded view (image coordinates, not relative to the
// sphere), in pixels of the candidate: 0 for a pixel that does not see the sphere, infinite where a point has
// no image in the candidate.
double OraclePixelErrorPx(const CriterionView& recorded, const CriterionView& candidate,
                          const Subject& subject, const Eigen::Vector2d& img, int cone_rays);

// Returns the same with the cone thinned to the rays of one plane, through pixels from `img` - `step` to
// `img` + `step` in `samples` steps.
double OracleLineErrorPx(const CriterionView& recorded, const CriterionView& candidate,
                         const Subject& subject, const Eigen::Vector2d& img, const Eigen::Vector2d& step,
                         int samples);

// Returns the largest error over the pixels in the frame that see the sphere; infinite when there is none.
double OracleBoundPx(const CriterionView& recorded, const CriterionView& candidate, const Subject& subject,
                     const BoundOracleOptions& options = {});

// Returns the diameter of the whole sphere's image, px: no error is larger. It is infinite inside the sphere.
double SilhouettePx(const CriterionView& view, const Subject& subject);

}  // namespace ulf::test
