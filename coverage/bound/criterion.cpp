#include "coverage/bound/criterion.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "coverage/bound/epipolar_plane.h"

namespace ulf::coverage {
namespace {

using Eigen::Vector3d;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Tries the cheapest first: the central pixel, then the guess where it is reliable, else the scan.
double WorstPixelError(const EpipolarPlane& plane, double give_up_px) {
  const double central = plane.ErrorAt(std::clamp(0.0, plane.lowest_pixel(), plane.highest_pixel()));
  if (central >= give_up_px || central == kInfinity) return central;
  if (!plane.IsGuessReliable()) return std::max(central, plane.Scanned(give_up_px));
  const double guess = plane.FirstGuess();
  const double error = plane.ErrorAt(guess);
  const double best = std::max(central, error);
  if (best >= give_up_px || best == kInfinity) return best;
  return std::max(best, plane.Refined(guess, error, give_up_px));
}

// If the line through both views pierces the sphere, every plane through that line cuts it wide, and a
// candidate that looks past the centre may show another plane's radial motion larger than the one through the
// centre.
bool NeedsOtherPlanes(const CriterionView& recorded, const CriterionView& candidate, const Subject& subject) {
  constexpr double kAimed = 0.9994;  // cosine of two degrees
  const Vector3d to_s = recorded.center_in_world - subject.center_in_world;
  const Vector3d to_n = candidate.center_in_world - subject.center_in_world;
  if (-candidate.cam_from_world.row(2).dot(to_n) > kAimed * to_n.norm()) return false;
  const double line_to_center_squared = to_s.cross(to_n).squaredNorm();
  return line_to_center_squared < subject.radius * subject.radius * (to_n - to_s).squaredNorm();
}

double WorstOfOtherPlanes(const CriterionView& recorded, const CriterionView& candidate,
                          const Subject& subject, const Vector3d& across, double give_up_px) {
  constexpr int kPlanes = 6;
  const Vector3d line = (candidate.center_in_world - recorded.center_in_world).normalized();
  const Vector3d to_s = recorded.center_in_world - subject.center_in_world;
  const Vector3d first_normal = to_s.cross(across).normalized();
  double worst = 0;
  for (int i = 1; i < kPlanes && worst < give_up_px; ++i) {
    const double turn = M_PI * i / kPlanes;
    const Vector3d normal = std::cos(turn) * first_normal + std::sin(turn) * line.cross(first_normal);
    const double height = normal.dot(to_s);
    const double squared = subject.radius * subject.radius - height * height;
    if (squared <= 0) continue;
    const Subject cut{subject.center_in_world + height * normal, std::sqrt(squared)};
    const Vector3d cut_across = normal.cross(recorded.center_in_world - cut.center_in_world).normalized();
    const EpipolarPlane plane(recorded, candidate, cut, cut_across);
    if (plane.usable()) worst = std::max(worst, plane.Scanned(give_up_px));
  }
  return worst;
}

CriterionView Aimed(const CriterionSetup& setup, double angle, double distance) {
  // A frame that holds any image of the sphere: a plan asks about the subject, not about a sensor.
  CriterionView view;
  view.fx = view.fy = setup.focal_px;
  view.width = view.height = 1e9;
  view.cx = view.cy = 0.5e9;
  return view.AimedAt(Vector3d::Zero(), distance * Vector3d(std::sin(angle), 0, -std::cos(angle)),
                      -Vector3d::UnitY());
}

// Bisects between `inside`, whose value is within the threshold, and `outside`, whose value is above it.
template <typename Function>
double Crossing(const Function& value, double inside, double outside, double threshold) {
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (inside + outside);
    (value(middle) <= threshold ? inside : outside) = middle;
  }
  return inside;
}

}  // namespace

double BoundPx(const CriterionView& recorded, const CriterionView& candidate, const Subject& subject,
               double give_up_px) {
  const Vector3d across = AcrossAxis(recorded, candidate, subject);
  const EpipolarPlane plane(recorded, candidate, subject, across);
  if (!plane.usable()) return kInfinity;
  const double bound = WorstPixelError(plane, give_up_px);
  if (bound >= give_up_px || !NeedsOtherPlanes(recorded, candidate, subject)) return bound;
  return std::max(bound, WorstOfOtherPlanes(recorded, candidate, subject, across, give_up_px));
}

// The central ray alone spreads over 2 f (r/d) sin(angle) / (1 - (r/d)² cos²(angle)) in an aimed candidate
// (equation 3), whatever the recorded view's distance; off its axis a camera shows at least (1 - (r/d)²) of
// that.
double MaxCoveringSine(const CriterionView& candidate, const Subject& subject, double threshold_px) {
  const double distance = (candidate.center_in_world - subject.center_in_world).norm();
  if (distance <= subject.radius) return kInfinity;
  const double ratio = subject.radius / distance;
  return threshold_px / (2 * std::min(candidate.fx, candidate.fy) * ratio * (1 - ratio * ratio));
}

double AimedBoundPx(const CriterionSetup& setup, double angle, double distance_ratio) {
  const Subject subject{Vector3d::Zero(), setup.radius};
  return BoundPx(Aimed(setup, 0, setup.distance), Aimed(setup, angle, setup.distance * distance_ratio),
                 subject);
}

std::optional<double> DiscRadius(const CriterionSetup& setup, double distance_ratio) {
  const auto bound = [&](double angle) { return AimedBoundPx(setup, angle, distance_ratio); };
  if (bound(0) > setup.threshold_px) return std::nullopt;
  // Looks for the first crossing in steps that grow from a share of the angle that parallax alone allows.
  double inside = 0;
  double step =
      0.02 * setup.threshold_px * setup.distance * distance_ratio / (2 * setup.focal_px * setup.radius);
  step = std::clamp(step, 1e-9, 0.02);
  while (inside < M_PI) {
    const double next = std::min(inside + step, M_PI);
    if (bound(next) > setup.threshold_px) return Crossing(bound, inside, next, setup.threshold_px);
    inside = next;
    step = std::min(1.05 * step, 0.02);
  }
  return M_PI;
}

std::optional<DistanceLimits> DistanceWindow(const CriterionSetup& setup) {
  const auto bound = [&](double ratio) { return AimedBoundPx(setup, 0, ratio); };
  if (bound(1) > setup.threshold_px) return std::nullopt;
  constexpr double kStep = 1.002;
  constexpr double kFarthest = 1000;
  DistanceLimits limits;
  const double touching = setup.radius / setup.distance;
  for (double ratio = 1; ratio > touching && !limits.near; ratio /= kStep)
    if (bound(ratio / kStep) > setup.threshold_px)
      limits.near = Crossing(bound, ratio, ratio / kStep, setup.threshold_px);
  for (double ratio = 1; ratio < kFarthest && !limits.far; ratio *= kStep)
    if (bound(ratio * kStep) > setup.threshold_px)
      limits.far = Crossing(bound, ratio, ratio * kStep, setup.threshold_px);
  return limits;
}

}  // namespace ulf::coverage
