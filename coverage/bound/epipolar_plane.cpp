#include "coverage/bound/epipolar_plane.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace ulf::coverage {
namespace {

using Eigen::Vector3d;

constexpr double kConeRadiusPx = 1;
constexpr double kParallel = 1e-9;  // sine, or depth of a unit vector: less is rounding

}  // namespace

struct EpipolarPlane::Extent {
  double low = kInfinity;
  double high = -kInfinity;
  bool broken = false;  // some part has no image

  void Include(double img) {
    low = std::min(low, img);
    high = std::max(high, img);
  }
  double Length() const { return broken ? kInfinity : std::max(0.0, high - low); }
};

Vector3d AcrossAxis(const CriterionView& recorded, const CriterionView& candidate, const Subject& subject) {
  const Vector3d toward_s = (recorded.center_in_world - subject.center_in_world).normalized();
  const Vector3d toward_n = (candidate.center_in_world - subject.center_in_world).normalized();
  for (const Vector3d& hint :
       {toward_n, Vector3d(candidate.cam_from_world.row(2)), Vector3d(recorded.cam_from_world.row(2))}) {
    const Vector3d across = hint - hint.dot(toward_s) * toward_s;
    const double length = across.norm();
    if (length > kParallel) return across / length;
  }
  return toward_s.unitOrthogonal();
}

EpipolarPlane::EpipolarPlane(const CriterionView& recorded, const CriterionView& candidate,
                             const Subject& subject, const Vector3d& across)
    : radius_(subject.radius) {
  const Vector3d to_s = recorded.center_in_world - subject.center_in_world;
  const Vector3d to_n = candidate.center_in_world - subject.center_in_world;
  recorded_distance_ = to_s.norm();
  candidate_distance_ = to_n.norm();
  if (!(recorded_distance_ > 0) || !(candidate_distance_ > 0)) return;
  if (candidate_distance_ <= radius_) return;

  const Vector3d p = to_s / recorded_distance_;
  const Vector3d q = to_n.dot(across) < 0 ? Vector3d(-across) : across;
  cos_ = to_n.dot(p) / candidate_distance_;
  sin_ = to_n.dot(q) / candidate_distance_;

  const Vector3d s_axis = recorded.cam_from_world * -p, s_across = recorded.cam_from_world * q;
  const Vector3d n_axis = candidate.cam_from_world * (-cos_ * p - sin_ * q);
  const Vector3d n_across = candidate.cam_from_world * (-sin_ * p + cos_ * q);
  if (s_axis.z() <= kParallel || n_axis.z() <= kParallel) return;  // the centre lies behind one of them
  s_.emplace(recorded, s_axis, s_across);
  n_.emplace(candidate, n_axis, n_across);

  BoundPixelsByFrame(recorded, s_axis);
  if (recorded_distance_ > radius_) {
    tangent_slope_ = radius_ / std::sqrt((recorded_distance_ - radius_) * (recorded_distance_ + radius_));
    const auto limit = [&](double slope) {
      return s_->axis_depth + slope * s_->across_depth > 0 ? s_->ImgFromSlope(slope)
                                                           : std::copysign(kInfinity, slope);
    };
    lowest_ = std::max(lowest_, limit(-tangent_slope_));
    highest_ = std::min(highest_, limit(tangent_slope_));
  }
  FindSilhouette();
  usable_ = lowest_ <= highest_;
}

// Only pixels in s's frame count. The frame is replaced by the disc around O's image that holds it, because
// its corners may lie farther out than its edge does along the epipolar line.
void EpipolarPlane::BoundPixelsByFrame(const CriterionView& recorded, const Vector3d& to_center) {
  const double x = recorded.fx * to_center.x() / to_center.z() + recorded.cx;
  const double y = recorded.fy * to_center.y() / to_center.z() + recorded.cy;
  const double near_x = std::clamp(x, 0.0, recorded.width), near_y = std::clamp(y, 0.0, recorded.height);
  if (near_x != x || near_y != y) {
    // O is out of the frame: the frame's nearest pixel may still see the sphere.
    const Vector3d ray((near_x - recorded.cx) / recorded.fx, (near_y - recorded.cy) / recorded.fy, 1);
    if (recorded_distance_ * ray.cross(to_center).norm() > radius_ * ray.norm()) return;
  }
  highest_ = std::hypot(std::max(x, recorded.width - x), std::max(y, recorded.height - y));
  lowest_ = -highest_;
}

// Finds where n's tangent rays touch the sphere: the only points of the arcs at which the region's image can
// end.
void EpipolarPlane::FindSilhouette() {
  const double ratio = radius_ / candidate_distance_;
  const double side = std::sqrt((1 - ratio) * (1 + ratio));
  for (const int sign : {-1, 1}) {
    const double p = radius_ * (cos_ * ratio - sign * sin_ * side);
    const double q = radius_ * (sin_ * ratio + sign * cos_ * side);
    const double along = recorded_distance_ - p;
    const double slope_in_n = sign * ratio / side;
    if (s_->Depth(along, q) <= 0 || n_->Depth(1, slope_in_n) <= 0) continue;
    SilhouettePoint& point = silhouette_[sign > 0 ? 1 : 0];
    point.pixel_in_s = s_->ImgFromSlope(q / along);
    point.img_in_n = n_->ImgFromSlope(slope_in_n);
  }
}

// Includes the images in n of the two points where the ray enters and leaves the sphere.
void EpipolarPlane::IncludeRay(double slope, Extent* extent) const {
  slope = std::clamp(slope, -tangent_slope_, tangent_slope_);  // a ray past the sphere becomes the tangent
  const double d = recorded_distance_;
  const double stretch = 1 + slope * slope;
  const double half = std::sqrt(std::max(0.0, radius_ * radius_ * stretch - d * d * slope * slope));
  const double first_along = std::max((d - half) / stretch, 0.0);
  const double last_along = std::max((d + half) / stretch, first_along);

  const auto in_n = [&](double along) {
    const double p = d - along, q = along * slope;
    return std::array<double, 2>{candidate_distance_ - p * cos_ - q * sin_, q * cos_ - p * sin_};
  };
  const auto first = in_n(first_along), last = in_n(last_along);
  const double first_depth = n_->Depth(first[0], first[1]), last_depth = n_->Depth(last[0], last[1]);
  if (std::min(first_depth, last_depth) <= 0) {
    extent->broken = true;
    return;
  }
  extent->Include(n_->scale * first[1] / first_depth);
  extent->Include(n_->scale * last[1] / last_depth);
}

double EpipolarPlane::ErrorAt(double pixel_px) const {
  Extent extent;
  IncludeRay(s_->SlopeFromImg(pixel_px - kConeRadiusPx), &extent);
  IncludeRay(s_->SlopeFromImg(pixel_px + kConeRadiusPx), &extent);
  for (const SilhouettePoint& point : silhouette_)
    if (std::abs(point.pixel_in_s - pixel_px) <= kConeRadiusPx) extent.Include(point.img_in_n);
  return extent.Length();
}

// Returns the pixel of a single ray's largest parallax, with a constant denominator (equation 5).
double EpipolarPlane::FirstGuess() const {
  const double sideways = candidate_distance_ * std::abs(sin_);
  const double ahead = candidate_distance_ * cos_ - recorded_distance_;
  const double beta = std::abs(ahead) * radius_ / recorded_distance_;
  const double sum = sideways + std::sqrt(sideways * sideways + 8 * beta * beta);
  const double share = sum > 0 ? 2 * beta / sum : 0;
  const double sine = std::copysign(radius_ / recorded_distance_ * share, ahead);
  return std::clamp(s_->ImgFromSlope(sine / std::sqrt(1 - sine * sine)), lowest_, highest_);
}

double EpipolarPlane::Refined(double guess, double error, double give_up_px) const {
  constexpr int kRounds = 2;
  constexpr double kFirstStep = 0.12, kNarrowing = 0.35;  // the first one of half the interval
  double best = error;
  double step = kFirstStep * 0.5 * (highest_ - lowest_);
  for (int round = 0; round < kRounds && best < give_up_px; ++round, step *= kNarrowing) {
    const double middle = std::clamp(guess, lowest_ + step, highest_ - step);
    const double before = ErrorAt(middle - step), after = ErrorAt(middle + step);
    const double here = middle == guess ? error : ErrorAt(middle);
    const double curvature = before - 2 * here + after;
    double next = before > after ? middle - step : middle + step;
    if (curvature < 0)
      next = std::clamp(middle + 0.5 * step * (before - after) / curvature, middle - 2 * step,
                        middle + 2 * step);
    guess = std::clamp(next, lowest_, highest_);
    error = ErrorAt(guess);
    best = std::max({best, before, here, after, error});
  }
  return best;
}

// Returns the largest error between two pixels, by golden section.
double EpipolarPlane::Top(double low, double high) const {
  constexpr double kGolden = 0.6180339887498949;
  constexpr int kSections = 18;
  double inner = high - kGolden * (high - low), outer = low + kGolden * (high - low);
  double inner_error = ErrorAt(inner), outer_error = ErrorAt(outer);
  for (int i = 0; i < kSections; ++i) {
    if (inner_error > outer_error) {
      high = outer, outer = inner, outer_error = inner_error;
      inner = high - kGolden * (high - low), inner_error = ErrorAt(inner);
    } else {
      low = inner, inner = outer, inner_error = outer_error;
      outer = low + kGolden * (high - low), outer_error = ErrorAt(outer);
    }
  }
  return std::max(inner_error, outer_error);
}

double EpipolarPlane::Scanned(double give_up_px) const {
  constexpr int kSteps = 32;
  const double step = (highest_ - lowest_) / kSteps;
  double best = 0, at = lowest_;
  const auto look_at = [&](double pixel) {
    const double error = ErrorAt(pixel);
    if (error > best) best = error, at = pixel;
    return best >= give_up_px || best == kInfinity;
  };
  const auto top_within = [&](double reach) {
    return Top(std::max(lowest_, at - reach), std::min(highest_, at + reach));
  };
  for (int i = 0; i <= kSteps; ++i)
    if (look_at(lowest_ + i * step)) return best;
  const double at_of_steps = at;
  // With n close to the sphere there are peaks between the steps: where a cone ends at n's silhouette, and
  // where it lies between both sides of the silhouette.
  const auto& [left, right] = silhouette_;
  for (const double pixel :
       {left.pixel_in_s - kConeRadiusPx, left.pixel_in_s + kConeRadiusPx, right.pixel_in_s - kConeRadiusPx,
        right.pixel_in_s + kConeRadiusPx, 0.5 * (left.pixel_in_s + right.pixel_in_s)})
    if (pixel >= lowest_ && pixel <= highest_ && look_at(pixel)) return best;
  best = std::max(best, top_within(step));
  return at == at_of_steps ? best : std::max(best, top_within(kConeRadiusPx));
}

// At about the same distance and at angles at which the denominator hardly changes over the sphere. Elsewhere
// the maximum moves away, and inside the sphere there is no guess.
bool EpipolarPlane::IsGuessReliable() const {
  constexpr double kShell = 0.25, kDenominatorChange = 0.03;
  const double ratio = candidate_distance_ / recorded_distance_;
  return recorded_distance_ > radius_ && std::abs(ratio - 1) <= kShell &&
         std::abs(sin_) * radius_ <= kDenominatorChange * recorded_distance_ && cos_ >= 0;
}

}  // namespace ulf::coverage
