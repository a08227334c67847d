#include "tracking/tracker/row_motion.h"

#include <algorithm>

#include "core/base/quantile.h"
#include "tracking/estimation/absolute_pose.h"

namespace ulf::tracking {

using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

// Guessed.
// One standard deviation of the velocity about a frame minus the one since the frame before, for a
// trembling hand, and of the velocity where there was no frame before: radians per second and, for the
// translation, median depths per second. Smaller ones miss tremor, larger ones follow a stretched map.
constexpr double kRowTremor = 0.03, kRowUnknown = 0.5;
constexpr double kRowDifferenceRate = 0.4;  // the newest difference's weight in the recent mean

}  // namespace

void RowMotion::Forget() {
  velocity_.reset();
  before_.reset();
}

void RowMotion::Scale(double scale) {
  if (velocity_) velocity_->tail<3>() *= scale;
  mean_difference_.tail<3>() *= scale;
  if (!before_) return;
  before_->by_rows.tail<3>() *= scale;
  before_->between.tail<3>() *= scale;
}

void RowMotion::InitializeFrom(TwoViewStart& start) {
  std::vector<double> first_depths;
  for (const Vector3d& point : start.points) first_depths.push_back(point.z());
  const double scale = 1 / std::max(1e-9, Median(std::move(first_depths)));
  Rigid3 second_from_first = start.second_from_first;
  second_from_first.translation *= scale;
  const auto velocity_of = [&](TrackedImage& image, const Rigid3& pose, const std::vector<Vector2d>& px_s) {
    std::vector<PointFlow> flow;
    std::vector<DepthField::Sample> depths;
    for (std::size_t i = 0; i < start.points.size(); ++i) {
      const Vector3d in_cam = pose * (scale * start.points[i]);
      flow.push_back({in_cam, px_s[i]});
      if (const auto img = camera_.ImgFromCam(in_cam)) depths.push_back({*img, in_cam.z()});
    }
    const auto velocity = TwistFromFlow(camera_, flow);
    if (velocity && rolls()) GiveRows(image, *velocity, depths);
    return velocity;
  };
  Forget();
  start.first_velocity = velocity_of(start.first, Rigid3{}, start.first_flow);
  start.second_velocity = velocity_of(start.second, second_from_first, start.second_flow);
  velocity_ = start.second_velocity;
}

void RowMotion::GiveRows(TrackedImage& image, const Twist& velocity,
                         std::span<const DepthField::Sample> depths) const {
  const auto rows =
      std::make_shared<const RowShift>(camera_, readout_s_, velocity, DepthField(camera_, depths));
  if (!image.detected) image.detected = image.features;
  image.features = RemoveRows(camera_, *image.detected, *rows);
  image.pyramid = WithRows(*image.pyramid, rows);
}

void RowMotion::RemoveExpectedShift(TrackedImage& image, const Rigid3& predicted,
                                    std::span<const Vector3d> points_in_world) const {
  if (!velocity_ || points_in_world.empty()) return;
  std::vector<DepthField::Sample> depths;
  for (const Vector3d& point : points_in_world) {
    const Vector3d in_cam = predicted * point;
    if (const auto img = camera_.ImgFromCam(in_cam)) depths.push_back({*img, in_cam.z()});
  }
  GiveRows(image, *velocity_, depths);
}

void RowMotion::RefineWithRows(TrackedImage& image, FramePose& frame_pose,
                               const std::optional<Twist>& between, bool with_corners) {
  std::vector<SeenPoint> seen;
  std::vector<double> depths;
  for (const PointMatch& match : frame_pose.matches) {
    const Vector3d& point = frame_pose.CandidateOf(match).position;
    const Vector3d in_cam = frame_pose.cam_from_world * point;
    depths.push_back(in_cam.z());
    seen.push_back({point, image.pyramid->Seen(match.img, &in_cam), match.sigma_px});
  }
  const std::size_t matches = seen.size();
  if (with_corners && image.fiducials)
    for (const PointObservation& corner : image.fiducials->corners)
      seen.push_back({corner.point_in_world, corner.img, corner.sigma_px});
  const double depth = Median(std::move(depths));
  const double sigma = between ? kRowTremor : kRowUnknown;
  MotionPrior prior;
  prior.twist = between ? *between : velocity_.value_or(Twist::Zero());
  prior.sigma << Vector3d::Constant(sigma), Vector3d::Constant(sigma * depth);
  auto refined = RefinePoseAndMotion(camera_, readout_s_, seen, frame_pose.cam_from_world, prior);
  if (!refined) return;
  if (between) {
    if (before_) {
      const Twist difference = before_->by_rows - 0.5 * (before_->between + *between);
      mean_difference_ +=
          std::max(kRowDifferenceRate, 1.0 / ++differences_) * (difference - mean_difference_);
    }
    before_ = Before{refined->twist, *between};
    constexpr double kFixed = 1e-6;  // of the prior's sigma: the velocity is given
    prior.twist = refined->twist - mean_difference_;
    prior.sigma *= kFixed;
    refined = RefinePoseAndMotion(camera_, readout_s_, seen, frame_pose.cam_from_world, prior);
    if (!refined) return;
  }
  velocity_ = frame_pose.twist = refined->twist;
  frame_pose.cam_from_world = refined->cam_from_world;
  // No observation is an outlier because the rows displace it: all weigh the same.
  constexpr RefinePoseOptions kAllAlike{.huber_sigmas = 1e3, .rounds = 1};
  std::vector<PointObservation> in_picture;
  for (const SeenPoint& point : seen)
    in_picture.push_back({point.point_in_world, point.seen, point.sigma_px});
  if (const auto picture = RefinePose(camera_, in_picture, frame_pose.cam_from_world, kAllAlike))
    frame_pose.picture_from_cam = picture->cam_from_world * frame_pose.cam_from_world.Inverse();
  std::vector<DepthField::Sample> around;
  for (const SeenPoint& point : seen)
    around.push_back({point.seen, (frame_pose.cam_from_world * point.point_in_world).z()});
  GiveRows(image, *velocity_, around);
  for (std::size_t i = 0; i < matches; ++i) {
    const Vector3d in_cam = frame_pose.cam_from_world * seen[i].point_in_world;
    frame_pose.matches[i].img = image.pyramid->Global(seen[i].seen, &in_cam);
  }
}

}  // namespace ulf::tracking
