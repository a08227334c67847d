// Computes the coverage bound: how far, in pixels of a new view, a recorded view may misplace what it shows
// of the subject when nothing is known of the subject but its bounding sphere. (Thesis, chapter 4, figure
// 4-1.)
//
// A pixel of the recorded view s is the cone of rays through the circle of one pixel spacing around it. Cut
// with the sphere, the cone leaves a region in which the pixel's surface point lies; the region's image in
// the new view n is the set of its possible reprojections, and the longest distance within that image is the
// pixel's error. The bound is that error at the worst pixel, not at the central one: the central pixel is
// blind to radial motion.
//
// The worst pixel lies in the epipolar plane through the sphere's centre O, in which it is searched
// (epipolar_plane.h). Both poses count as they are: a camera that does not aim at O stretches what it sees
// off its axis.
//
// The bound is infinite, so that s cannot cover n, when s cannot see the sphere (behind it, out of its frame)
// or part of the region has no image in n (n inside the sphere, O behind n).
//
// Frame: world coordinates, any unit. Pixels: those of the coverage image, without distortion. The bound is
// not symmetric, and of a view with itself it is 2 px, so that a threshold must exceed that. No call
// allocates.
#pragma once

#include <limits>
#include <optional>

#include "core/light_field/light_field.h"
#include "coverage/bound/capture_presets.h"
#include "coverage/bound/criterion_view.h"

namespace ulf::coverage {

// Returns the bound, in pixels of `candidate`; infinite when `recorded` cannot cover it at all. The search
// ends as soon as it meets an error of `give_up_px` or more, and returns that error.
double BoundPx(const CriterionView& recorded, const CriterionView& candidate, const Subject& subject,
               double give_up_px = std::numeric_limits<double>::infinity());

// Returns an upper bound of the sine of the angle, seen from the centre, at which a recorded view can still
// cover the candidate; 1 or more: any angle.
double MaxCoveringSine(const CriterionView& candidate, const Subject& subject, double threshold_px);

// Describes a capture before there are views: a camera of focal length `focal_px` (coverage image) aims at
// the centre of a sphere of `radius` from `distance`, both in any one unit.
struct CriterionSetup {
  double focal_px = 0;
  double distance = 0;
  double radius = 0;
  double threshold_px = kHighThresholdPx;
};

// Returns the bound between two aimed cameras `angle` (radians, seen from the centre) apart: the recorded one
// is at `distance`, the candidate at `distance_ratio` times that.
double AimedBoundPx(const CriterionSetup& setup, double angle, double distance_ratio);

// Returns how far around a recorded view the candidates at `distance_ratio` times its distance are covered:
// the angle seen from the centre, radians. Returns none where not even the same direction is; pi where every
// direction is.
std::optional<double> DiscRadius(const CriterionSetup& setup, double distance_ratio = 1);

// Describes how much nearer and farther than the recorded view a candidate in the same direction may be:
// ratios of new distance to recorded distance at the first crossing of the threshold on each side. None: no
// limit on that side.
struct DistanceLimits {
  std::optional<double> near;
  std::optional<double> far;
};
// Returns none where not even the recorded view's own place is covered.
std::optional<DistanceLimits> DistanceWindow(const CriterionSetup& setup);

}  // namespace ulf::coverage
