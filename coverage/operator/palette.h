// Defines the colours of the coverage map and of what is drawn on it. A recorded view is coloured by its
// distance from the subject compared with the present camera's (thesis, section 3.2), from nearer over the
// same to farther; the colours are full where the present distance leaves the view's distance window
// (DistanceWindow() in criterion.h).
#pragma once

#include <Eigen/Core>

#include "coverage/bound/coverage_map.h"
#include "render/display/shapes.h"

namespace ulf::coverage {

struct Palette {
  render::Rgba same, farther, nearer;                    // recorded distances
  render::Rgba reopened;                                 // directions that must be taken again
  render::Rgba guide;                                    // the way to go, and headings
  render::Rgba alarm;                                    // the subject is not in the safety rectangle
  render::Rgba camera;                                   // the dot of the present camera
  render::Rgba error_small, error_at_goal, error_large;  // measured errors

  // Interpolates `same` at 0, `nearer` at 1 and beyond, `farther` at -1.
  render::Rgba OfNearer(double nearer_by) const;

  // Interpolates `error_at_goal` at 0, `error_small` at kErrorReach_db above the goal, `error_large` as far
  // below it.
  render::Rgba OfError(double db_above_goal) const;
  static constexpr double kErrorReach_db = 6;

  static const Palette& Standard();
  // Orange, pale and blue differ for every common kind of colour vision, and in lightness.
  static const Palette& ForColourBlind();
};

// Turns a recorded distance into a colour, compared with the present one.
class DistanceColors {
 public:
  // `map` has views; `present_distance`: from the subject's centre, world units; `palette` outlives it.
  DistanceColors(const CoverageMap& map, double present_distance, const Palette& palette);
  render::Rgba Of(const CriterionView& recorded) const { return palette_.OfNearer(Nearer(recorded)); }
  // Returns 0 for the same distance, 1 where the view is so much nearer that it just does not cover any more,
  // -1 where it is as much farther.
  double Nearer(double recorded_distance) const;
  double Nearer(const CriterionView& recorded) const {
    return Nearer((recorded.center_in_world - center_).norm());
  }

  // Ratios of present to recorded distance at which the colours are full.
  double farthest_recorded() const { return nearest_; }
  double nearest_recorded() const { return farthest_; }

 private:
  const Palette& palette_;
  double present_distance_;
  double nearest_ = 0.9, farthest_ = 1.1;
  Eigen::Vector3d center_;
};

}  // namespace ulf::coverage
