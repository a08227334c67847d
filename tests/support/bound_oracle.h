// The coverage bound by brute force, straight from its definition: every pixel of the recorded view that sees
// the sphere, rays in space around the circle of one pixel, where they enter and leave the sphere, those
// points projected into the candidate, the longest distance between any two. No epipolar plane, no closed
// form. Slow.
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

// The error of the pixel at `img` of the recorded view (image coordinates, not relative to the sphere).
double OraclePixelErrorPx(const CriterionView& recorded, const CriterionView& candidate,
                          const Subject& subject, const Eigen::Vector2d& img, int cone_rays);

// The same with the cone thinned to rays in one plane: `samples` pixels from `img` - `step` to `img` +
// `step`.
double OracleLineErrorPx(const CriterionView& recorded, const CriterionView& candidate,
                         const Subject& subject, const Eigen::Vector2d& img, const Eigen::Vector2d& step,
                         int samples);

// The largest error over the pixels in the frame that see the sphere; infinite when there is none.
double OracleBoundPx(const CriterionView& recorded, const CriterionView& candidate, const Subject& subject,
                     const BoundOracleOptions& options = {});

// The image of the whole sphere: no error is larger.
double SilhouettePx(const CriterionView& view, const Subject& subject);

}  // namespace ulf::test
