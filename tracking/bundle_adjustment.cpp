#include "tracking/bundle_adjustment.h"

#include <algorithm>
#include <cmath>

#include "tracking/residuals.h"

namespace ulf {
namespace {

using Eigen::Vector3d;

// Below this many free cameras the dense reduced system is faster than anything clever.
constexpr int kDenseCameras = 120;

class StopWhenAsked final : public ceres::IterationCallback {
 public:
  explicit StopWhenAsked(const std::atomic<bool>& stop) : stop_(stop) {}
  ceres::CallbackReturnType operator()(const ceres::IterationSummary&) override {
    return stop_ ? ceres::SOLVER_TERMINATE_SUCCESSFULLY : ceres::SOLVER_CONTINUE;
  }

 private:
  const std::atomic<bool>& stop_;
};

double SquaredError(const CameraModel& camera, const BundleProblem& problem, const BundleObservation& seen) {
  const auto img = camera.ImgFromCam(problem.cam_from_world[static_cast<std::size_t>(seen.camera)] *
                                     problem.points[static_cast<std::size_t>(seen.point)]);
  return img ? (*img - seen.img).squaredNorm() / (seen.sigma_px * seen.sigma_px) : 1e8;
}

double Rms(const CameraModel& camera, const BundleProblem& problem) {
  double sum = 0;
  int count = 0;
  for (const BundleObservation& seen : problem.observations) {
    if (seen.outlier) continue;
    sum += std::min(1e4, SquaredError(camera, problem, seen));
    ++count;
  }
  return count ? std::sqrt(sum / count) : 0;
}

ceres::Solver::Summary Solve(const CameraModel& camera, BundleProblem& problem,
                             const std::vector<bool>& fixed, int iterations, const BundleOptions& options) {
  ceres::Problem::Options ownership;
  ownership.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ownership.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ceres::Problem ceres_problem(ownership);
  ceres::HuberLoss huber(options.huber_sigmas);
  PoseManifold manifold;

  std::vector<PoseBlock> poses;
  for (const Rigid3& pose : problem.cam_from_world) poses.push_back(ToBlock(pose));
  std::vector<bool> used_camera(poses.size()), used_point(problem.points.size());
  for (const BundleObservation& seen : problem.observations) {
    if (seen.outlier) continue;
    const auto c = static_cast<std::size_t>(seen.camera), p = static_cast<std::size_t>(seen.point);
    ceres_problem.AddResidualBlock(new ReprojectionCost(camera, seen.img, seen.sigma_px), &huber,
                                   poses[c].data(), problem.points[p].data());
    used_camera[c] = used_point[p] = true;
  }
  auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
  int free_cameras = 0;
  for (std::size_t c = 0; c < poses.size(); ++c) {
    if (!used_camera[c]) continue;
    ceres_problem.SetManifold(poses[c].data(), &manifold);
    if (fixed[c]) ceres_problem.SetParameterBlockConstant(poses[c].data());
    free_cameras += !fixed[c];
    ordering->AddElementToGroup(poses[c].data(), 1);
  }
  for (std::size_t p = 0; p < problem.points.size(); ++p)
    if (used_point[p]) ordering->AddElementToGroup(problem.points[p].data(), 0);

  ceres::Solver::Options solver;
  solver.linear_solver_type = free_cameras <= kDenseCameras ? ceres::DENSE_SCHUR : ceres::ITERATIVE_SCHUR;
  solver.preconditioner_type = ceres::SCHUR_JACOBI;
  solver.linear_solver_ordering = ordering;
  solver.max_num_iterations = iterations;
  solver.num_threads = 1;
  solver.function_tolerance = 1e-5;
  solver.logging_type = ceres::SILENT;
  std::unique_ptr<StopWhenAsked> stopper;
  if (options.stop) {
    stopper = std::make_unique<StopWhenAsked>(*options.stop);
    solver.callbacks.push_back(stopper.get());
  }
  ceres::Solver::Summary summary;
  ceres::Solve(solver, &ceres_problem, &summary);
  for (std::size_t c = 0; c < poses.size(); ++c)
    if (used_camera[c] && !fixed[c]) {
      problem.cam_from_world[c] = FromBlock(poses[c].data());
      problem.cam_from_world[c].rotation.normalize();
    }
  return summary;
}

int MarkOutliers(const CameraModel& camera, BundleProblem& problem, double gate_sigmas) {
  int outliers = 0;
  for (BundleObservation& seen : problem.observations) {
    seen.outlier = SquaredError(camera, problem, seen) > gate_sigmas * gate_sigmas;
    outliers += seen.outlier;
  }
  return outliers;
}

// Scales the world about the only fixed camera so that the farthest other camera is as far as it was.
void RestoreScale(BundleProblem& problem, std::size_t anchor, const std::vector<Vector3d>& centers_before) {
  std::size_t farthest = anchor;
  double distance = 0;
  for (std::size_t c = 0; c < centers_before.size(); ++c)
    if ((centers_before[c] - centers_before[anchor]).norm() > distance) {
      distance = (centers_before[c] - centers_before[anchor]).norm();
      farthest = c;
    }
  const Vector3d origin = centers_before[anchor];
  const double now = (problem.cam_from_world[farthest].OriginInSource() - origin).norm();
  if (farthest == anchor || !(now > 0)) return;
  const double scale = distance / now;
  for (Rigid3& pose : problem.cam_from_world) {
    const Vector3d center = origin + scale * (pose.OriginInSource() - origin);
    pose.translation = -(pose.rotation * center);
  }
  for (Vector3d& point : problem.points) point = origin + scale * (point - origin);
}

}  // namespace

BundleSummary AdjustBundle(const CameraModel& camera, BundleProblem& problem, const BundleOptions& options) {
  BundleSummary summary;
  if (problem.cam_from_world.empty() || problem.observations.empty()) {
    summary.message = "nothing to adjust";
    return summary;
  }
  std::vector<bool> fixed = problem.fixed;
  fixed.resize(problem.cam_from_world.size(), false);
  if (std::find(fixed.begin(), fixed.end(), true) == fixed.end()) fixed[0] = true;
  std::vector<Vector3d> centers_before;
  for (const Rigid3& pose : problem.cam_from_world) centers_before.push_back(pose.OriginInSource());

  const BundleProblem before = problem;
  summary.initial_rms_sigmas = Rms(camera, problem);
  const auto robust = Solve(camera, problem, fixed, options.robust_iterations, options);
  summary.outliers = MarkOutliers(camera, problem, options.gate_sigmas);
  summary.iterations = static_cast<int>(robust.iterations.size());
  summary.usable = robust.IsSolutionUsable();
  summary.message = robust.message;
  const bool stopped = options.stop && *options.stop;
  if (summary.usable && options.iterations > 0 && !stopped) {
    const auto last = Solve(camera, problem, fixed, options.iterations, options);
    summary.outliers = MarkOutliers(camera, problem, options.gate_sigmas);
    summary.iterations += static_cast<int>(last.iterations.size());
    summary.usable = last.IsSolutionUsable();
    summary.message = last.message;
  }
  if (!summary.usable) {
    problem = before;
    return summary;
  }
  if (std::count(fixed.begin(), fixed.end(), true) == 1)
    RestoreScale(problem,
                 static_cast<std::size_t>(std::find(fixed.begin(), fixed.end(), true) - fixed.begin()),
                 centers_before);
  summary.final_rms_sigmas = Rms(camera, problem);
  return summary;
}

}  // namespace ulf
