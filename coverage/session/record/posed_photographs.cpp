#include "coverage/session/record/posed_photographs.h"

#include <algorithm>
#include <random>
#include <utility>

#include "core/base/quantile.h"
#include "core/geometry/angles.h"

namespace ulf::coverage {
namespace {

// The sharpest of neighbouring frames is recorded: those within this share of the spacing from their first
// one, and at most so many. Guessed.
constexpr double kWalkNeighbourShare = 0.4;
constexpr int kWalkMostNeighbours = 6;
// Points of a frame: fewer say nothing, of more a sample is taken. Guessed.
constexpr std::size_t kWalkFewestPoints = 12, kWalkMostPoints = 150;
// After so many points a view is dismissed that contains less than this share of `least_overlap`. Guessed.
constexpr std::size_t kWalkFirstPoints = 20;
constexpr double kWalkFirstOverlap = 0.3;

// In random order, so that the first few stand for all.
std::vector<tracking::VisiblePoint> Sample(std::vector<tracking::VisiblePoint> points, std::size_t most) {
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

// Returns whether a view at `before_from_world` shows the same as the frame that shows `points` from
// `cam_from_world`.
bool ShowsSameView(const Rigid3& before_from_world, const Rigid3& cam_from_world, const CameraModel& camera,
                   const std::vector<tracking::VisiblePoint>& points, const PhotographSpacing& spacing) {
  const Eigen::Vector3d here = cam_from_world.OriginInSource(), there = before_from_world.OriginInSource();
  std::vector<double> parallax;
  std::size_t shared = 0;
  for (const tracking::VisiblePoint& point : points) {
    if (parallax.size() == kWalkFirstPoints &&
        static_cast<double>(shared) <
            kWalkFirstOverlap * spacing.least_overlap * static_cast<double>(kWalkFirstPoints))
      return false;
    parallax.push_back(AngleBetween(point.position_in_world - here, point.position_in_world - there));
    const auto img = camera.ImgFromCam(before_from_world * point.position_in_world);
    shared += img && camera.Contains(*img);
  }
  return static_cast<double>(shared) >= spacing.least_overlap * static_cast<double>(points.size()) &&
         Degrees(Median(std::move(parallax))) <= spacing.parallax_deg;
}

}  // namespace

bool PosedPhotographs::IsLocated(const FrameToDecide& input,
                                 const std::vector<tracking::VisiblePoint>& points) const {
  return input.track.state == tracking::TrackState::kTracking && !input.track.skipped &&
         input.track.cam_from_world && points.size() >= kWalkFewestPoints;
}

bool PosedPhotographs::IsNeighbour(const FrameToDecide& input,
                                   const std::vector<tracking::VisiblePoint>& points) const {
  PhotographSpacing near = spacing_;
  near.parallax_deg *= kWalkNeighbourShare;
  near.least_overlap = 1 - kWalkNeighbourShare * (1 - spacing_.least_overlap);
  return neighbours_ < kWalkMostNeighbours &&
         ShowsSameView(*first_, *input.track.cam_from_world, input.camera, points, near);
}

Decision PosedPhotographs::Judge(const FrameToDecide& input,
                                 const std::vector<tracking::VisiblePoint>& sample,
                                 const RecordedViews& views, const HeldFrame* about_to_be_recorded) const {
  if (!IsLocated(input, sample)) return {};
  const auto shows_same = [&](const Rigid3& before_from_world, const CameraModel& camera) {
    return ShowsSameView(before_from_world, *input.track.cam_from_world, camera, sample, spacing_);
  };
  const bool shown =
      (about_to_be_recorded && shows_same(*about_to_be_recorded->track.cam_from_world, input.camera)) ||
      std::ranges::any_of(views.views(), [&](const RecordedViews::Entry& view) {
        return shows_same(view.cam_from_world, view.CameraOr(input.camera));
      });
  return DecideWithoutSubject(input, shown);
}

PosedPhotographs::Step PosedPhotographs::Decide(const FrameToDecide& input,
                                                const std::vector<tracking::VisiblePoint>& all_points,
                                                const RecordedViews& views) const {
  const std::vector<tracking::VisiblePoint> points = Sample(all_points, kWalkMostPoints);
  Step step;
  step.located = IsLocated(input, points);
  step.ends_held = held_ && !(step.located && IsNeighbour(input, points));
  if (!step.located) return step;
  step.decision = Judge(input, points, views, step.ends_held ? &*held_ : nullptr);
  if (step.decision.reason != Reason::kRecorded) return step;
  step.depth = MedianDepth(all_points);
  if (!held_ || step.ends_held) return step;
  step.replaces = input.track.sharpness > held_->track.sharpness;
  if (!step.replaces) step.decision.reason = Reason::kCovered;
  return step;
}

std::optional<HeldFrame> PosedPhotographs::Take(const Step& step, const FrameToDecide& input) {
  std::optional<HeldFrame> ended;
  if (step.ends_held) ended = TakeHeld();
  if (!step.located) return ended;
  neighbours_ += held_.has_value();
  if (step.decision.reason != Reason::kRecorded) return ended;
  if (!held_) {
    first_ = *input.track.cam_from_world;
    neighbours_ = 0;
  }
  held_ = HeldFrame{input.frame, input.track, step.depth};
  return ended;
}

std::optional<HeldFrame> PosedPhotographs::TakeHeld() { return std::exchange(held_, std::nullopt); }

}  // namespace ulf::coverage
