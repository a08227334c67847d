#include "tracking/estimation/absolute_pose.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/base/at.h"
#include "core/base/quantile.h"
#include "core/geometry/angles.h"
#include "core/geometry/small_matrices.h"
#include "tracking/estimation/opengv_bridge.h"
#include "tracking/estimation/sampling.h"

namespace ulf::tracking {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Matrix6d = Eigen::Matrix<double, 6, 6>;
using Vector6d = Eigen::Matrix<double, 6, 1>;

// The next constants are of the search for another pose that explains the matches about as well. Guessed.
// Poses are clearly different whose turns differ by more, or whose centres do, as a share of the distance.
constexpr double kDifferentTurnDeg = 5, kDifferentShift = 0.05;
// Samples that are drawn, those of the largest area that propose poses, and rivals that are refined: more
// find more rivals and cost time.
constexpr std::size_t kRivalsDrawn = 60, kRivalsUsed = 8, kRivalsRefined = 6;
// A rival counts whose cost is worse by less than this many variances of the noise, or than this many an
// inlier; more refuses more poses, less accepts more wrong ones.
constexpr double kRivalLeastMargin = 60, kRivalMarginPerInlier = 0.25;
constexpr double kLeastNoisePx = 0.1;  // one standard deviation of the matches, at least

// Squared error that counts for a point that cannot be projected: a smaller one makes steps that lose
// points look cheap. Guessed.
constexpr double kLostPointSigmas2 = 1e4;
// PoseRefinement::center_sigma is scaled by the true error over the one that independent errors of the
// residuals' size would make (measured: docs/measured/tracking.md, "What the quality value says"), and the
// least residual, in sigmas, because few residuals can be small by chance (guessed).
constexpr double kCommonError = 1.5, kLeastResidual = 0.1;

struct NormalEquations {
  Matrix6d hessian = Matrix6d::Zero();
  Vector6d gradient = Vector6d::Zero();
  double cost = 0;
};

NormalEquations Linearize(const CameraModel& camera, std::span<const PointObservation> observations,
                          const std::vector<bool>& used, const Rigid3& pose,
                          const RefinePoseOptions& options) {
  const double huber = options.huber_sigmas;
  // A row of the Jacobian and its residual, padded to two vectors: the products of six entries with all of
  // them are the upper rows of the normal matrix and, in the seventh column, the gradient.
  using Double4 = double __attribute__((vector_size(32)));
  Double4 left[6] = {}, right[6] = {};
  double cost = 0;
  const Matrix3d rotation = pose.RotationMatrix();
  for (std::size_t i = 0; i < observations.size(); ++i) {
    if (!used[i]) continue;
    const Vector3d point = rotation * observations[i].point_in_world + pose.translation;
    Eigen::Matrix<double, 2, 3> img_by_point;
    const auto img = camera.ImgFromCam(point, &img_by_point);
    if (!img) {
      cost += HuberCost(kLostPointSigmas2, huber);
      continue;
    }
    const double inverse_variance = 1 / (observations[i].sigma_px * observations[i].sigma_px);
    const Vector2d residual = *img - observations[i].img;
    const double squared = residual.squaredNorm() * inverse_variance;
    cost += HuberCost(squared, huber);
    const double weight = inverse_variance * (squared <= huber * huber ? 1 : huber / std::sqrt(squared));
    for (int row = 0; row < 2; ++row) {
      // A turn of the camera frame by w moves the point by w x point.
      const Vector3d move = img_by_point.row(row), turn = point.cross(move);
      const double entries[6] = {turn.x(), turn.y(), turn.z(), move.x(), move.y(), move.z()};
      const Double4 first = weight * Double4{turn.x(), turn.y(), turn.z(), move.x()};
      const Double4 second = weight * Double4{move.y(), move.z(), residual(row), 0};
      for (int k = 0; k < 6; ++k) {
        left[k] += entries[k] * first;
        right[k] += entries[k] * second;
      }
    }
  }
  NormalEquations equations;
  equations.cost = cost;
  for (int k = 0; k < 6; ++k) {
    equations.hessian.row(k) << left[k][0], left[k][1], left[k][2], left[k][3], right[k][0], right[k][1];
    equations.gradient(k) = right[k][2];
  }
  return equations;
}

struct Minimum {
  Rigid3 pose;
  NormalEquations equations;  // there
};

Minimum Minimize(const CameraModel& camera, std::span<const PointObservation> observations,
                 const std::vector<bool>& used, const Rigid3& initial, const RefinePoseOptions& options) {
  Minimum minimum{initial, Linearize(camera, observations, used, initial, options)};
  double damping = 1e-6;
  for (int iteration = 0; iteration < options.max_iterations; ++iteration) {
    bool moved = false;
    double step_size = 0;
    for (int attempt = 0; attempt < 5 && !moved; ++attempt) {
      Matrix6d damped = minimum.equations.hessian;
      damped.diagonal() *= 1 + damping;
      const Vector6d step = -SolveNormal(damped, minimum.equations.gradient);
      if (!step.allFinite()) return minimum;
      step_size = step.head<3>().norm() + step.tail<3>().norm() / (1 + minimum.pose.translation.norm());
      // So small a step leaves the equations as they are.
      if (step_size < options.min_step) return minimum;
      const Rigid3 candidate = Perturbed(minimum.pose, step);
      const NormalEquations there = Linearize(camera, observations, used, candidate, options);
      if (there.cost <= minimum.equations.cost) {
        minimum = {candidate, there};
        damping = std::max(1e-9, damping * 0.1);
        moved = true;
      } else {
        damping = std::max(1e-4, damping * 30);
      }
    }
    if (!moved) break;
  }
  return minimum;
}

class PoseSearch {
 public:
  PoseSearch(const CameraModel& camera, std::span<const PointObservation> observations,
             const AbsolutePoseOptions& options)
      : camera_(camera), options_(options) {
    for (std::size_t i = 0; i < observations.size(); ++i)
      if (const auto ray = camera.RayFromImg(observations[i].img)) {
        seen_.push_back(observations[i]);
        rays_.push_back(*ray);
        index_.push_back(static_cast<int>(i));
      }
  }

  std::optional<AbsolutePoseResult> Run() const {
    const auto found = SampleConsensus<Rigid3>(
        static_cast<int>(seen_.size()), 3, [&](const auto& sample) { return Solve(sample); },
        [&](const Rigid3& pose, int i) { return Residual2(pose, i); },
        [&](const Rigid3& pose, const auto& inliers) { return Improve(pose, inliers); },
        {.threshold = options_.threshold_px,
         .max_iterations = options_.max_iterations,
         .seed = options_.seed});
    if (!found || static_cast<int>(found->inliers.size()) < options_.min_inliers) return std::nullopt;
    const auto pose = BestOfRivals(*found);
    if (!pose) return std::nullopt;
    AbsolutePoseResult result{*pose, {}, found->iterations};
    for (const int i : Inliers(*pose)) result.inliers.push_back(index_[At(i)]);
    return result;
  }

 private:
  struct ScoredPose {
    double cost = 0;
    Rigid3 pose;
  };

  std::vector<Rigid3> Solve(const std::vector<int>& sample) const {
    std::array<Vector3d, 3> points, rays;
    for (std::size_t k = 0; k < 3; ++k) {
      points[k] = seen_[At(sample[k])].point_in_world;
      rays[k] = rays_[At(sample[k])];
    }
    return SolveP3p(points, rays);
  }

  double Residual2(const Rigid3& pose, int i) const {
    const PointObservation& seen = seen_[At(i)];
    const auto img = camera_.ImgFromCam(pose * seen.point_in_world);
    return img ? (*img - seen.img).squaredNorm() : std::numeric_limits<double>::infinity();
  }

  std::optional<Rigid3> Improve(const Rigid3& pose, const std::vector<int>& inliers) const {
    if (inliers.size() < 6) return std::nullopt;
    std::vector<PointObservation> used;
    for (const int i : inliers) {
      used.push_back(seen_[At(i)]);
      used.back().sigma_px = options_.threshold_px / kSigmas95;
    }
    const auto refined = RefinePose(camera_, used, pose, {.rounds = 1, .max_iterations = 5});
    return refined ? std::optional(refined->cam_from_world) : std::nullopt;
  }

  std::vector<int> Inliers(const Rigid3& pose) const {
    std::vector<int> inliers;
    for (int i = 0; i < static_cast<int>(seen_.size()); ++i)
      if (Residual2(pose, i) < options_.threshold_px * options_.threshold_px) inliers.push_back(i);
    return inliers;
  }

  ScoredPose Score(const Rigid3& pose) const {
    double cost = 0;
    for (int i = 0; i < static_cast<int>(seen_.size()); ++i)
      cost += std::min(Residual2(pose, i), options_.threshold_px * options_.threshold_px);
    return {cost, pose};
  }

  bool ClearlyDifferent(const Rigid3& a, const Rigid3& b, double distance) const {
    return RotationAngle(a.rotation * b.rotation.conjugate()) > Radians(kDifferentTurnDeg) ||
           (a.OriginInSource() - b.OriginInSource()).norm() > kDifferentShift * distance;
  }

  // Returns the poses of samples of three inliers far apart in the image, which are therefore accurate.
  std::vector<ScoredPose> RivalPoses(const std::vector<int>& inliers) const {
    std::mt19937 random(options_.seed);
    std::vector<std::pair<double, std::vector<int>>> samples;  // by falling area
    for (std::size_t k = 0; k < kRivalsDrawn; ++k) {
      std::vector<int> sample(3);
      internal::DrawSample(random, static_cast<int>(inliers.size()), sample);
      for (int& i : sample) i = inliers[At(i)];
      const auto ray = [&](std::size_t at) { return rays_[At(sample[at])]; };
      samples.emplace_back(-(ray(1) - ray(0)).cross(ray(2) - ray(0)).norm(), sample);
    }
    const std::size_t used = kRivalsUsed;
    std::partial_sort(samples.begin(), samples.begin() + static_cast<long>(used), samples.end());
    std::vector<ScoredPose> rivals;
    for (std::size_t k = 0; k < used; ++k)
      for (const Rigid3& pose : Solve(samples[k].second)) rivals.push_back(Score(pose));
    return rivals;
  }

  // Three points have up to four poses, a far plane has two, and the search may have ended with a wrong one.
  // Returns none where a clearly different pose explains the matches about as well.
  std::optional<Rigid3> BestOfRivals(const SamplingResult<Rigid3>& found) const {
    std::vector<double> distances;
    for (const int i : found.inliers) distances.push_back((found.model * seen_[At(i)].point_in_world).norm());
    const double distance = Median(std::move(distances));
    std::vector<ScoredPose> rivals = RivalPoses(found.inliers);
    std::erase_if(rivals, [&](const ScoredPose& rival) {
      return !ClearlyDifferent(rival.pose, found.model, distance);
    });
    std::ranges::sort(rivals, [](const auto& a, const auto& b) { return a.cost < b.cost; });
    if (rivals.size() > kRivalsRefined) rivals.resize(kRivalsRefined);
    ScoredPose best{found.cost, found.model};
    rivals.push_back(best);
    for (ScoredPose& rival : rivals) {
      for (int round = 0; round < 2; ++round)
        if (const auto improved = Improve(rival.pose, Inliers(rival.pose)))
          if (const ScoredPose scored = Score(*improved); scored.cost < rival.cost) rival = scored;
      if (rival.cost < best.cost) best = rival;
    }
    std::vector<double> errors;
    for (const int i : Inliers(best.pose)) errors.push_back(std::sqrt(Residual2(best.pose, i)));
    const double noise_px = std::max(kLeastNoisePx, Median(std::move(errors)) / kMedianLength);
    // Noise, and unmodelled errors of some percent, make a smaller difference between two that are as good.
    const double margin =
        std::max(kRivalLeastMargin, kRivalMarginPerInlier * static_cast<double>(found.inliers.size())) *
        noise_px * noise_px;
    for (const ScoredPose& rival : rivals)
      if (rival.cost - best.cost < margin && ClearlyDifferent(rival.pose, best.pose, distance))
        return std::nullopt;
    return best.pose;
  }

  const CameraModel& camera_;
  const AbsolutePoseOptions& options_;
  std::vector<PointObservation> seen_;
  std::vector<Vector3d> rays_;
  std::vector<int> index_;  // into the matches that were given; those without a ray are left out
};

}  // namespace

Rigid3 Perturbed(const Rigid3& cam_from_world, const Vector6d& twist) {
  const Vector3d omega = twist.head<3>();
  const double angle = omega.norm();
  const Eigen::Quaterniond turn =
      angle > 1e-12 ? Eigen::Quaterniond(Eigen::AngleAxisd(angle, omega / angle))
                    : Eigen::Quaterniond(1, 0.5 * omega.x(), 0.5 * omega.y(), 0.5 * omega.z());
  return {(turn * cam_from_world.rotation).normalized(), turn * cam_from_world.translation + twist.tail<3>()};
}

std::optional<PoseRefinement> RefinePose(const CameraModel& camera,
                                         std::span<const PointObservation> observations,
                                         const Rigid3& initial, const RefinePoseOptions& options) {
  constexpr int kMinimum = 4;
  PoseRefinement result;
  result.cam_from_world = initial;
  result.inlier.assign(observations.size(), true);
  result.inliers = static_cast<int>(observations.size());
  const double gate2 = options.gate_sigmas * options.gate_sigmas;
  NormalEquations equations;
  bool settled = false;
  for (int round = 0; round < options.rounds && !settled; ++round) {
    if (result.inliers < kMinimum) return std::nullopt;
    const Minimum minimum = Minimize(camera, observations, result.inlier, result.cam_from_world, options);
    result.cam_from_world = minimum.pose;
    equations = minimum.equations;
    const Matrix3d rotation = minimum.pose.RotationMatrix();
    std::vector<bool> inlier(observations.size());
    result.inliers = 0;
    for (std::size_t i = 0; i < observations.size(); ++i) {
      const auto img =
          camera.ImgFromCam(rotation * observations[i].point_in_world + minimum.pose.translation);
      const double sigma = observations[i].sigma_px;
      inlier[i] = img && (*img - observations[i].img).squaredNorm() <= gate2 * sigma * sigma;
      result.inliers += inlier[i];
    }
    settled = inlier == result.inlier;
    result.inlier = std::move(inlier);
  }
  if (result.inliers < kMinimum) return std::nullopt;
  if (!settled) equations = Linearize(camera, observations, result.inlier, result.cam_from_world, options);
  const Eigen::FullPivLU<Matrix6d> lu(equations.hessian);
  if (!lu.isInvertible()) return std::nullopt;
  result.covariance = lu.inverse();
  // The centre is -R^T t; under a twist of the camera frame it moves by -R^T v. Residuals scale the sigmas,
  // but do not show the error that neighbouring points, and the map, have in common.
  const double residual_sigmas = std::sqrt(equations.cost / std::max(1, 2 * result.inliers - 6));
  result.center_sigma = kCommonError * std::max(kLeastResidual, residual_sigmas) *
                        std::sqrt(std::max(0.0, result.covariance.bottomRightCorner<3, 3>().trace()));
  return result;
}

std::optional<AbsolutePoseResult> AbsolutePose(const CameraModel& camera,
                                               std::span<const PointObservation> observations,
                                               const AbsolutePoseOptions& options) {
  return PoseSearch(camera, observations, options).Run();
}

}  // namespace ulf::tracking
