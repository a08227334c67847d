// Searches the coverage bound of a pair of views in the plane through both of them and the sphere's centre O
// (criterion.h, docs/coverage_bound.md "Set-up"): both cameras are one-dimensional projective cameras, a
// pixel's cone two rays. Coordinates (p, q) have their origin at O; p points towards the recorded view s, q
// across it to the side of the new view n.
//
// Pixels of s are image coordinates along the epipolar line, counted from O's image towards n's side; 0 is
// the thesis's central pixel. Errors are in pixels of n. No call allocates.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "core/light_field/light_field.h"
#include "coverage/bound/criterion_view.h"

namespace ulf::coverage {

// Returns a unit vector perpendicular to the direction from O to `recorded`, in the plane through O and both
// views. Where these lie on one line, the plane that holds the optical axes is taken, because it shows their
// stretch.
Eigen::Vector3d AcrossAxis(const CriterionView& recorded, const CriterionView& candidate,
                           const Subject& subject);

class EpipolarPlane {
 public:
  // `subject`: the sphere's cut with the plane, its centre in the plane. `across` is perpendicular to the
  // direction from that centre to s.
  EpipolarPlane(const CriterionView& recorded, const CriterionView& candidate, const Subject& subject,
                const Eigen::Vector3d& across);

  // Returns false where the bound is infinite whatever the pixel: then nothing below may be called.
  bool usable() const { return usable_; }
  double lowest_pixel() const { return lowest_; }  // of those in s's frame that see the circle
  double highest_pixel() const { return highest_; }
  double ErrorAt(double pixel_px) const;  // infinite where part of the pixel's region has no image in n
  // Returns whether the worst pixel is where FirstGuess() says, or so near that Refined() finds it.
  bool IsGuessReliable() const;
  // Returns the pixel of docs/coverage_bound.md, "Closed forms", 3. s must be outside the circle.
  double FirstGuess() const;
  // Returns the largest error met in two parabola steps from the pixel `guess`, whose error is `error`. This
  // search and Scanned() end as soon as they meet an error of `give_up_px` or more.
  double Refined(double guess, double error, double give_up_px) const;
  // Returns the largest error over 33 pixels and the peaks between them, refined by golden sections.
  double Scanned(double give_up_px) const;

 private:
  // A pinhole camera in a plane through its centre. A direction of the plane is its slope against the
  // direction to O; its image coordinate is the signed length along the plane's image line, 0 at O's image.
  // The map is projective.
  struct PlaneCamera {
    double scale = 0;         // px
    double axis_depth = 1;    // depth of a unit step towards O
    double across_depth = 0;  // depth of a unit step across

    // `to_center` and `across`: the plane's unit axes in the camera frame.
    PlaneCamera(const CriterionView& view, const Eigen::Vector3d& to_center, const Eigen::Vector3d& across)
        : axis_depth(to_center.z()), across_depth(across.z()) {
      const double x = view.fx * (across.x() * axis_depth - to_center.x() * across_depth);
      const double y = view.fy * (across.y() * axis_depth - to_center.y() * across_depth);
      scale = std::sqrt(x * x + y * y) / axis_depth;
    }

    double Depth(double along, double sideways) const { return along * axis_depth + sideways * across_depth; }
    double ImgFromSlope(double slope) const { return scale * slope / (axis_depth + slope * across_depth); }
    double SlopeFromImg(double img) const { return img * axis_depth / (scale - img * across_depth); }
  };
  void BoundPixelsByFrame(const CriterionView& recorded, const Eigen::Vector3d& to_center);
  void FindSilhouette();
  struct Extent;  // what the region's corners reach in n's image
  void IncludeRay(double slope, Extent* extent) const;
  double Top(double low, double high) const;

  double radius_;
  double recorded_distance_ = 0, candidate_distance_ = 0;
  double cos_ = 1, sin_ = 0;  // of the angle between the views
  std::optional<PlaneCamera> s_, n_;
  static constexpr double kInfinity = std::numeric_limits<double>::infinity();
  double tangent_slope_ = kInfinity;                  // slope of s's tangent rays; infinite with s inside
  double lowest_ = kInfinity, highest_ = -kInfinity;  // pixels of s that see the sphere
  struct SilhouettePoint {
    double pixel_in_s = kInfinity;
    double img_in_n = 0;
  };
  std::array<SilhouettePoint, 2> silhouette_;
  bool usable_ = false;
};

}  // namespace ulf::coverage
