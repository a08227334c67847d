#include "tracking/estimation/rolling_shutter.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "core/base/at.h"
#include "core/base/quantile.h"
#include "core/geometry/small_matrices.h"
#include "tracking/estimation/absolute_pose.h"
#include "tracking/estimation/two_view_motion.h"

namespace ulf::tracking {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

// RefinePoseAndMotion() uses these.
constexpr int kMotionIterations = 4;              // at most. Guessed
constexpr int kMotionMinPoints = 8;               // fewer do not determine pose and velocity
constexpr double kMotionHuberSigmas = kSigmas95;  // beyond it an observation weighs less
constexpr double kMotionMinStep = 1e-6;           // radians; a smaller step ends the iterations. Guessed

// TwistFromFlow() uses these.
constexpr int kFlowRounds = 8;      // of weighing what does not fit less. Guessed
constexpr int kFlowMinPoints = 12;  // fewer give no velocity. Guessed
constexpr double kFlowReach = 3;    // times the usual misfit: beyond it a point weighs less. Guessed

}  // namespace

Vector3d PointAfter(const Twist& twist, const Vector3d& point, double time_s, Matrix3d* by_point,
                    Eigen::Matrix<double, 3, 6>* by_twist) {
  const Vector3d omega = twist.head<3>();
  const Vector3d turned = omega.cross(point);
  const double half = 0.5 * time_s * time_s;
  if (by_point || by_twist) {
    const Matrix3d turning = CrossMatrix(omega);
    if (by_point) *by_point = Matrix3d::Identity() + time_s * turning + half * turning * turning;
    if (by_twist) {
      const Matrix3d of_point = CrossMatrix(point);
      by_twist->leftCols<3>() = -time_s * of_point - half * (CrossMatrix(turned) + turning * of_point);
      by_twist->rightCols<3>() = time_s * Matrix3d::Identity();
    }
  }
  return point + time_s * (turned + twist.tail<3>()) + half * omega.cross(turned);
}

Twist TwistBetween(const Rigid3& before, const Rigid3& after, double step_s) {
  const Rigid3 after_from_before = after * before.Inverse();
  const Eigen::AngleAxisd turn(after_from_before.rotation);
  Twist twist;
  twist << turn.angle() * turn.axis(), after_from_before.translation;
  return twist / step_s;
}

DepthField::DepthField(const CameraModel& camera, std::span<const Sample> samples)
    : width_(camera.width), height_(camera.height) {
  double mean = 0;
  for (const Sample& sample : samples) mean += 1 / sample.depth;
  mean = samples.empty() ? 0 : mean / static_cast<double>(samples.size());
  inverse_.assign(kColumns * kRows, kMeanWeight * mean);
  std::vector<double> weights(kColumns * kRows, kMeanWeight);
  for (const Sample& sample : samples) {
    const auto [first, fx, fy] = CornerOf(sample.img);
    for (std::size_t k = 0; k < 4; ++k) {
      const double across = k % 2 ? fx : 1 - fx, down = k / 2 ? fy : 1 - fy;
      const std::size_t node = first + k / 2 * kColumns + k % 2;
      inverse_[node] += across * down / sample.depth;
      weights[node] += across * down;
    }
  }
  for (std::size_t i = 0; i < inverse_.size(); ++i) inverse_[i] /= weights[i];
}

DepthField::Corner DepthField::CornerOf(const Vector2d& img) const {
  const double x = std::clamp(img.x() / width_, 0.0, 1.0) * (kColumns - 1);
  const double y = std::clamp(img.y() / height_, 0.0, 1.0) * (kRows - 1);
  const int column = std::min(static_cast<int>(x), kColumns - 2);
  const int row = std::min(static_cast<int>(y), kRows - 2);
  return {ulf::At(row * kColumns + column), x - column, y - row};
}

double DepthField::At(const Vector2d& img) const {
  const auto [first, fx, fy] = CornerOf(img);
  const double* node = &inverse_[first];
  const double inverse = (1 - fy) * ((1 - fx) * node[0] + fx * node[1]) +
                         fy * ((1 - fx) * node[kColumns] + fx * node[kColumns + 1]);
  return inverse > 1 / kFar ? 1 / inverse : kFar;
}

void DepthField::Scale(double scale) {
  for (double& inverse : inverse_) inverse /= scale;
}

RowShift::RowShift(const CameraModel& camera, double readout_s, const Twist& twist, DepthField depths)
    : camera_(camera), readout_s_(readout_s), twist_(twist), depths_(std::move(depths)) {}

RowShift RowShift::Scaled(double scale) const {
  RowShift scaled = *this;
  scaled.twist_.tail<3>() *= scale;
  scaled.depths_.Scale(scale);
  return scaled;
}

Vector2d RowShift::Moved(const Vector3d& point_in_cam, double time_s) const {
  const auto at_once = camera_.ImgFromCam(point_in_cam);
  const auto then = camera_.ImgFromCam(PointAfter(twist_, point_in_cam, time_s));
  return at_once && then ? Vector2d(*then - *at_once) : Vector2d(0, 0);
}

Vector2d RowShift::Global(const Vector2d& seen, const Vector3d& point_in_cam) const {
  return seen - Moved(point_in_cam, TimeOf(seen));
}

// Iterates: the row where the point is seen gives the time. A step reduces the error to some percent.
Vector2d RowShift::Seen(const Vector2d& global, const Vector3d& point_in_cam) const {
  Vector2d seen = global;
  for (int i = 0; i < 4; ++i) seen = global + Moved(point_in_cam, TimeOf(seen));
  return seen;
}

Vector2d RowShift::Global(const Vector2d& seen) const {
  const auto ray = camera_.RayFromImg(seen);
  if (!ray || ray->z() <= 0) return seen;
  return camera_.ImgFromCam(GlobalPoint(seen, *ray)).value_or(seen);
}

Vector3d RowShift::GlobalPoint(const Vector2d& seen, const Vector3d& ray) const {
  return PointAfter(twist_, ray * (depths_.At(seen) / ray.z()), -TimeOf(seen));
}

Vector2d RowShift::Seen(const Vector2d& global) const {
  Vector2d seen = global;
  for (int i = 0; i < 4; ++i) seen += global - Global(seen);
  return seen;
}

Vector2d Pyramid::Seen(const Vector2d& img, const Vector3d* point_in_cam) const {
  if (!rows) return img;
  return point_in_cam ? rows->Seen(img, *point_in_cam) : rows->Seen(img);
}

Vector2d Pyramid::Global(const Vector2d& seen, const Vector3d* point_in_cam) const {
  if (!rows) return seen;
  return point_in_cam ? rows->Global(seen, *point_in_cam) : rows->Global(seen);
}

std::shared_ptr<const FeatureSet> MoveFeatures(const CameraModel& camera, const FeatureSet& features,
                                               const RowShift* from, const RowShift* to) {
  std::vector<Feature> moved = features.all();
  for (Feature& feature : moved) {
    const Vector2d seen = from ? from->Seen(feature.img) : feature.img;
    const Vector2d global = to ? to->Global(seen) : seen;
    const auto ray = camera.RayFromImg(global);
    if (!ray) continue;  // keep it as it is: others refer to features by index
    feature.img = global;
    feature.ray = *ray;
  }
  return std::make_shared<const FeatureSet>(std::move(moved), camera.width, camera.height);
}

std::shared_ptr<const FeatureSet> RemoveRows(const CameraModel& camera, const FeatureSet& detected,
                                             const RowShift& rows) {
  std::vector<Feature> moved = detected.all();
  for (Feature& feature : moved) {
    if (feature.ray.z() <= 0) continue;
    const Vector3d point = rows.GlobalPoint(feature.img, feature.ray);
    const auto img = camera.ImgFromCam(point);
    if (!img) continue;  // keep it as it is: others refer to features by index
    feature.img = *img;
    feature.ray = point.normalized();
  }
  return std::make_shared<const FeatureSet>(std::move(moved), camera.width, camera.height);
}

std::shared_ptr<const Pyramid> WithRows(const Pyramid& pyramid, std::shared_ptr<const RowShift> rows) {
  Pyramid same = pyramid;  // the images are shared
  same.rows = std::move(rows);
  return std::make_shared<const Pyramid>(std::move(same));
}

std::optional<Twist> TwistFromFlow(const CameraModel& camera, std::span<const PointFlow> flow) {
  Twist twist = Twist::Zero();
  double scale = 0;  // median misfit, px/s
  for (int round = 0; round < kFlowRounds; ++round) {
    Eigen::Matrix<double, 6, 6> normal = Eigen::Matrix<double, 6, 6>::Zero();
    Twist right = Twist::Zero();
    std::vector<double> misfits;
    for (const PointFlow& point : flow) {
      Eigen::Matrix<double, 2, 3> img_by_point;
      if (!point.px_s.allFinite() || !camera.ImgFromCam(point.point_in_cam, &img_by_point)) continue;
      Eigen::Matrix<double, 2, 6> jacobian;
      for (int row = 0; row < 2; ++row) {
        const Vector3d move = img_by_point.row(row);
        jacobian.row(row) << point.point_in_cam.cross(move).transpose(), move.transpose();
      }
      const double misfit = (point.px_s - jacobian * twist).norm();
      misfits.push_back(misfit);
      const double reach = round == 0 ? 1 : std::min(1.0, kFlowReach * scale / std::max(1e-9, misfit));
      const double weight = reach * reach;
      normal += weight * jacobian.transpose() * jacobian;
      right += weight * jacobian.transpose() * point.px_s;
    }
    if (static_cast<int>(misfits.size()) < kFlowMinPoints) return std::nullopt;
    twist = SolveNormal(normal, right);
    if (!twist.allFinite()) return std::nullopt;
    scale = Median(std::move(misfits));
  }
  return twist;
}

std::optional<PoseAndMotion> RefinePoseAndMotion(const CameraModel& camera, double readout_s,
                                                 std::span<const SeenPoint> points, const Rigid3& initial,
                                                 const MotionPrior& prior) {
  PoseAndMotion result{initial, prior.twist};
  const Twist prior_weight = prior.sigma.cwiseAbs2().cwiseInverse();
  for (int iteration = 0; iteration < kMotionIterations; ++iteration) {
    // With the pose's Jacobian A and a row's time t, that by pose and velocity is (A, t A).
    std::array<Eigen::Matrix<double, 6, 6>, 3> hessian;
    std::array<Twist, 2> gradient{Twist::Zero(), Twist::Zero()};
    hessian.fill(Eigen::Matrix<double, 6, 6>::Zero());
    const Matrix3d rotation = result.cam_from_world.RotationMatrix();
    int used = 0;
    for (const SeenPoint& point : points) {
      const double time_s = readout_s * (point.seen.y() / camera.height - 0.5);
      const Vector3d in_cam = PointAfter(
          result.twist, rotation * point.point_in_world + result.cam_from_world.translation, time_s);
      Eigen::Matrix<double, 2, 3> img_by_point;
      const auto img = camera.ImgFromCam(in_cam, &img_by_point);
      if (!img) continue;
      ++used;
      const Vector2d residual = (*img - point.seen) / point.sigma_px;
      const double length = residual.norm();
      const double weight = length <= kMotionHuberSigmas ? 1 : kMotionHuberSigmas / length;
      Eigen::Matrix<double, 2, 6> jacobian;
      for (int row = 0; row < 2; ++row) {
        const Vector3d move = img_by_point.row(row) / point.sigma_px;
        jacobian.row(row) << in_cam.cross(move).transpose(), move.transpose();
      }
      const Eigen::Matrix<double, 6, 6> square = weight * jacobian.transpose() * jacobian;
      const Twist slope = weight * jacobian.transpose() * residual;
      hessian[0] += square;
      hessian[1] += time_s * square;
      hessian[2] += time_s * time_s * square;
      gradient[0] += slope;
      gradient[1] += time_s * slope;
    }
    if (used < kMotionMinPoints) return std::nullopt;
    Eigen::Matrix<double, 12, 12> normal;
    normal << hessian[0], hessian[1], hessian[1], hessian[2];
    normal.bottomRightCorner<6, 6>().diagonal() += prior_weight;
    Eigen::Matrix<double, 12, 1> right;
    right << gradient[0], gradient[1] + prior_weight.cwiseProduct(result.twist - prior.twist);
    const Eigen::Matrix<double, 12, 1> step = -normal.ldlt().solve(right);
    if (!step.allFinite()) return std::nullopt;
    result.cam_from_world = Perturbed(result.cam_from_world, step.head<6>());
    result.twist += step.tail<6>();
    if (step.head<3>().norm() < kMotionMinStep &&
        step.segment<3>(6).norm() * std::abs(readout_s) < kMotionMinStep)
      break;
  }
  return result;
}

}  // namespace ulf::tracking
