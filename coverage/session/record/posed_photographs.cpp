#include "coverage/session/record/posed_photographs.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <utility>

#include "core/base/quantile.h"

namespace ulf::coverage {
namespace {

constexpr std::size_t kFewestPoints = 12, kMostPoints = 150;

// Enough of them to tell, in no order, so that the first few tell about all.
std::vector<tracking::VisiblePoint> Some(std::vector<tracking::VisiblePoint> points) {
  std::mt19937 draw(1);
  std::shuffle(points.begin(), points.end(), draw);
  if (points.size() > kMostPoints) points.resize(kMostPoints);
  return points;
}

bool IsLocated(const FrameToDecide& input, const std::vector<tracking::VisiblePoint>& points) {
  return input.track.state == tracking::TrackState::kTracking && !input.track.skipped &&
         input.track.cam_from_world && points.size() >= kFewestPoints;
}

}  // namespace

std::optional<double> MedianDepth(const std::vector<tracking::VisiblePoint>& points) {
  if (points.size() < kFewestPoints) return std::nullopt;
  std::vector<double> depths;
  for (const tracking::VisiblePoint& point : points) depths.push_back(point.depth);
  return Median(std::move(depths));
}

bool StandsFor(const Rigid3& before_from_world, const Rigid3& cam_from_world, const CameraModel& camera,
               const std::vector<tracking::VisiblePoint>& points, const PhotographSpacing& spacing) {
  constexpr std::size_t kFirst = 20;  // a view elsewhere has hardly any of them
  const Eigen::Vector3d here = cam_from_world.OriginInSource(), there = before_from_world.OriginInSource();
  std::vector<double> parallax;
  std::size_t shared = 0;
  for (const tracking::VisiblePoint& point : points) {
    if (parallax.size() == kFirst && static_cast<double>(shared) < 0.3 * spacing.least_overlap * kFirst)
      return false;
    const Eigen::Vector3d a = point.position_in_world - here, b = point.position_in_world - there;
    parallax.push_back(std::atan2(a.cross(b).norm(), a.dot(b)));
    const auto img = camera.ImgFromCam(before_from_world * point.position_in_world);
    shared += img && camera.Contains(*img);
  }
  return static_cast<double>(shared) >= spacing.least_overlap * static_cast<double>(points.size()) &&
         Median(std::move(parallax)) * 180 / M_PI <= spacing.parallax_deg;
}

// A hand goes on: what is much farther along is no longer the same photograph.
bool PosedPhotographs::IsANeighbour(const FrameToDecide& input,
                                    const std::vector<tracking::VisiblePoint>& points) const {
  constexpr double kNear = 0.4;
  constexpr int kMost = 6;
  const PhotographSpacing near{kNear * spacing_.parallax_deg, 1 - kNear * (1 - spacing_.least_overlap)};
  return neighbours_ < kMost && StandsFor(*first_, *input.track.cam_from_world, camera_, points, near);
}

Decision PosedPhotographs::Judge(const FrameToDecide& input,
                                 const std::vector<tracking::VisiblePoint>& some_points,
                                 const HeldViews& views, const HeldFrame* besides,
                                 const DecisionLimits& limits) const {
  if (!IsLocated(input, some_points)) return {};
  const auto stands = [&](const Rigid3& before_from_world) {
    return StandsFor(before_from_world, *input.track.cam_from_world, camera_, some_points, spacing_);
  };
  const bool shown = (besides && stands(*besides->track.cam_from_world)) ||
                     std::any_of(views.views().begin(), views.views().end(),
                                 [&](const HeldView& view) { return stands(view.cam_from_world); });
  return DecideWithoutSubject(input, shown, limits);
}

Decision PosedPhotographs::Judge(const FrameToDecide& input,
                                 const std::vector<tracking::VisiblePoint>& points, const HeldViews& views,
                                 const DecisionLimits& limits) const {
  return Judge(input, Some(points), views, nullptr, limits);
}

PosedPhotographs::Step PosedPhotographs::After(const FrameToDecide& input,
                                               const std::vector<tracking::VisiblePoint>& all_points,
                                               const HeldViews& views, const DecisionLimits& limits) {
  const std::vector<tracking::VisiblePoint> points = Some(all_points);
  const bool located = IsLocated(input, points);
  Step step;
  if (held_ && !(located && IsANeighbour(input, points))) step.record = TakeHeld();
  if (!located) return step;
  step.decision = Judge(input, points, views, step.record ? &*step.record : nullptr, limits);
  if (step.decision.reason != Reason::kRecorded) {
    neighbours_ += held_.has_value();
    return step;
  }
  const auto hold = [&] { held_ = HeldFrame{input.frame, input.track, *MedianDepth(all_points)}; };
  if (!held_) {
    first_ = *input.track.cam_from_world;
    neighbours_ = 0;
    hold();
  } else if (++neighbours_; input.track.sharpness > held_->track.sharpness) {
    hold();
    step.replaced = true;
  } else {
    step.decision.reason = Reason::kCovered;
  }
  return step;
}

std::optional<HeldFrame> PosedPhotographs::TakeHeld() { return std::exchange(held_, std::nullopt); }

}  // namespace ulf::coverage
