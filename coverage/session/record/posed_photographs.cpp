#include "coverage/session/record/posed_photographs.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <utility>

#include "core/base/quantile.h"

namespace ulf::coverage {
namespace {

// Enough of them to tell, in no order, so that the first few tell about all.
std::vector<tracking::VisiblePoint> Some(std::vector<tracking::VisiblePoint> points, std::size_t most) {
  std::mt19937 draw(1);
  std::shuffle(points.begin(), points.end(), draw);
  if (points.size() > most) points.resize(most);
  return points;
}

double MedianDepth(const std::vector<tracking::VisiblePoint>& points) {
  std::vector<double> depths;
  for (const tracking::VisiblePoint& point : points) depths.push_back(point.depth);
  return Median(std::move(depths));
}

}  // namespace

bool PosedPhotographs::IsLocated(const FrameToDecide& input,
                                 const std::vector<tracking::VisiblePoint>& points) const {
  return input.track.state == tracking::TrackState::kTracking && !input.track.skipped &&
         input.track.cam_from_world && points.size() >= spacing_.fewest_points;
}

bool ShowsSameView(const Rigid3& before_from_world, const Rigid3& cam_from_world, const CameraModel& camera,
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

bool PosedPhotographs::IsNeighbour(const FrameToDecide& input,
                                   const std::vector<tracking::VisiblePoint>& points) const {
  PhotographSpacing near = spacing_;
  near.parallax_deg *= spacing_.neighbour_share;
  near.least_overlap = 1 - spacing_.neighbour_share * (1 - spacing_.least_overlap);
  return neighbours_ < spacing_.most_neighbours &&
         ShowsSameView(*first_, *input.track.cam_from_world, camera_, points, near);
}

Decision PosedPhotographs::Judge(const FrameToDecide& input,
                                 const std::vector<tracking::VisiblePoint>& some_points,
                                 const RecordedViews& views, const HeldFrame* besides,
                                 const DecisionLimits& limits) const {
  if (!IsLocated(input, some_points)) return {};
  const auto stands = [&](const Rigid3& before_from_world) {
    return ShowsSameView(before_from_world, *input.track.cam_from_world, camera_, some_points, spacing_);
  };
  const bool shown =
      (besides && stands(*besides->track.cam_from_world)) ||
      std::any_of(views.views().begin(), views.views().end(),
                  [&](const RecordedViews::Entry& view) { return stands(view.cam_from_world); });
  return DecideWithoutSubject(input, shown, limits);
}

Decision PosedPhotographs::Judge(const FrameToDecide& input,
                                 const std::vector<tracking::VisiblePoint>& points,
                                 const RecordedViews& views, const DecisionLimits& limits) const {
  return Judge(input, Some(points, spacing_.most_points), views, nullptr, limits);
}

PosedPhotographs::Step PosedPhotographs::After(const FrameToDecide& input,
                                               const std::vector<tracking::VisiblePoint>& all_points,
                                               const RecordedViews& views, const DecisionLimits& limits) {
  const std::vector<tracking::VisiblePoint> points = Some(all_points, spacing_.most_points);
  const bool located = IsLocated(input, points);
  Step step;
  if (held_ && !(located && IsNeighbour(input, points))) step.record = TakeHeld();
  if (!located) return step;
  step.decision = Judge(input, points, views, step.record ? &*step.record : nullptr, limits);
  if (step.decision.reason != Reason::kRecorded) {
    neighbours_ += held_.has_value();
    return step;
  }
  const auto hold = [&] { held_ = HeldFrame{input.frame, input.track, MedianDepth(all_points)}; };
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
