#include "render/output/keyframes.h"

#include <algorithm>
#include <cmath>

#include "core/base/error.h"

namespace ulf::render {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Quaterniond;
using Eigen::Vector3d;
using Eigen::VectorXd;

CubicSpline::CubicSpline(std::vector<double> times, MatrixXd values)
    : times_(std::move(times)),
      values_(std::move(values)),
      second_(MatrixXd::Zero(values_.rows(), values_.cols())) {
  // Thomas's algorithm solves for the inner points: h0 m0 + 2 (h0 + h1) m1 + h1 m2 = 6 (slope1 - slope0).
  const auto step = [&](Index i) {
    return times_[static_cast<std::size_t>(i) + 1] - times_[static_cast<std::size_t>(i)];
  };
  const Index n = values_.rows();
  VectorXd upper = VectorXd::Zero(n);
  for (Index i = 1; i + 1 < n; ++i) {
    const double diagonal = 2 * (step(i - 1) + step(i)) - step(i - 1) * upper(i - 1);
    upper(i) = step(i) / diagonal;
    const Eigen::RowVectorXd bend = 6 * ((values_.row(i + 1) - values_.row(i)) / step(i) -
                                         (values_.row(i) - values_.row(i - 1)) / step(i - 1));
    second_.row(i) = (bend - step(i - 1) * second_.row(i - 1)) / diagonal;
  }
  for (Index i = n - 2; i > 0; --i) second_.row(i) -= upper(i) * second_.row(i + 1);
}

VectorXd CubicSpline::At(double time) const {
  if (times_.size() == 1) return values_.row(0).transpose();
  const auto above = std::upper_bound(times_.begin() + 1, times_.end() - 1, time);
  const Index i = above - times_.begin() - 1;
  const double from = times_[static_cast<std::size_t>(i)], h = *above - from;
  const double b = (time - from) / h, a = 1 - b;
  return (a * values_.row(i) + b * values_.row(i + 1) +
          ((a * a * a - a) * second_.row(i) + (b * b * b - b) * second_.row(i + 1)) * h * h / 6)
      .transpose();
}

std::vector<KeyframedPose> InterpolateKeyframes(const std::vector<PathKeyframe>& keyframes, int frames) {
  const Index count = static_cast<Index>(keyframes.size());
  std::vector<double> times;
  MatrixXd eyes(count, 3), targets(count, 3), ups(count, 3), turns(count, 4), lenses(count, 3);
  bool all_aim = true;
  Quaterniond before = Quaterniond::Identity();
  for (Index i = 0; i < count; ++i) {
    const PathKeyframe& key = keyframes[static_cast<std::size_t>(i)];
    times.push_back(key.time_s);
    eyes.row(i) = key.eye_in_world;
    targets.row(i) = key.target_in_world.value_or(Vector3d::Zero());
    ups.row(i) = key.up_in_world.normalized();
    all_aim = all_aim && key.target_in_world;
    Quaterniond turn =
        key.target_in_world
            ? LookAt(key.eye_in_world, *key.target_in_world, key.up_in_world).rotation.conjugate()
            : key.world_from_cam.normalized();
    if (i > 0 && turn.dot(before) < 0) turn.coeffs() = -turn.coeffs();
    before = turn;
    turns.row(i) = turn.coeffs();
    lenses.row(i) << std::log(key.focal_px), key.aperture_radius, std::log(key.focus_depth);
  }
  const CubicSpline eye(times, eyes), target(times, targets), up(times, ups), turn(times, turns),
      lens(times, lenses);
  std::vector<KeyframedPose> poses;
  for (int frame = 0; frame < frames; ++frame) {
    const double share = frames > 1 ? static_cast<double>(frame) / (frames - 1) : 0;
    const double time = times.front() + share * (times.back() - times.front());
    KeyframedPose& pose = poses.emplace_back();
    const VectorXd lens_now = lens.At(time);
    pose.focal_px = std::exp(lens_now(0));
    pose.aperture_radius = std::max(0.0, lens_now(1));
    pose.focus_depth = std::exp(lens_now(2));
    const Vector3d center = eye.At(time);
    const auto fail = [&](const char* what) {
      const auto after = std::upper_bound(times.begin(), times.end(), time) - times.begin();
      throw Error("between keyframes {} and {} {}; put another keyframe between them", after - 1, after,
                  what);
    };
    if (all_aim) {
      const Vector3d aim = target.At(time), upwards = up.At(time);
      if (!((aim - center).norm() > 0)) fail("the camera meets its target");
      constexpr double kLeastUp = 1e-3;  // of unit vectors' mean: excludes nearly opposite ones
      if (!(upwards.norm() > kLeastUp)) fail("up turns over");
      pose.cam_from_world = LookAt(center, aim, upwards);
      continue;
    }
    const VectorXd q = turn.At(time);
    constexpr double kLeastQuaternion = 0.1;  // of unit quaternions' mean: excludes nearly opposite ones
    if (!(q.norm() > kLeastQuaternion)) fail("the camera turns too far");
    pose.cam_from_world = Rigid3{Quaterniond(q(3), q(0), q(1), q(2)).normalized(), center}.Inverse();
  }
  return poses;
}

}  // namespace ulf::render
