#include "tracking/estimation/bundle_adjustment.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "core/base/at.h"
#include "core/base/quantile.h"
#include "core/geometry/silent_solver.h"
#include "tracking/estimation/residuals.h"

namespace ulf::tracking {
namespace {

using Eigen::Vector3d;

// The least scale of the errors over their sigmas: perfect measurements must not make the loss infinitely
// narrow. Guessed.
constexpr double kLeastErrorScale = 0.03;

class Watcher final : public ceres::IterationCallback {
 public:
  Watcher(const BundleOptions& options, int before) : options_(options), count_(before) {}
  ceres::CallbackReturnType operator()(const ceres::IterationSummary&) override {
    if (options_.progress) options_.progress(++count_);
    return options_.stop && *options_.stop ? ceres::SOLVER_TERMINATE_SUCCESSFULLY : ceres::SOLVER_CONTINUE;
  }

 private:
  const BundleOptions& options_;
  int count_;
};

std::size_t LensOf(const BundleProblem& problem, int camera) {
  return problem.lens.empty() ? 0 : At(problem.lens[At(camera)]);
}

const RowsMotion* RowsOf(const BundleProblem& problem, int camera) {
  const auto c = At(camera);
  return c < problem.rows.size() && problem.rows[c] ? &*problem.rows[c] : nullptr;
}

double Rms(const std::vector<CameraModel>& lenses, const BundleProblem& problem) {
  double sum = 0;
  int count = 0;
  for (const BundleObservation& seen : problem.observations) {
    if (seen.outlier) continue;
    sum += std::min(1e4, SquaredErrorSigmas(lenses, problem, seen));
    ++count;
  }
  return count ? std::sqrt(sum / count) : 0;
}

// The parameter blocks of a solution: Ceres keeps their addresses.
struct Blocks {
  std::vector<PoseBlock> poses;
  std::vector<IntrinsicsBlock> lenses;
  std::vector<Twist> twists;  // by camera
  std::vector<bool> used_camera, used_lens, used_point;
};

void AddObservations(const std::vector<CameraModel>& lenses, BundleProblem& problem, Blocks& blocks,
                     ceres::LossFunction* loss, const BundleOptions& options, ceres::Problem& ceres_problem) {
  for (const BundleObservation& seen : problem.observations) {
    if (seen.outlier) continue;
    const auto c = At(seen.camera), p = At(seen.point);
    const std::size_t l = LensOf(problem, seen.camera);
    if (RowsOf(problem, seen.camera))
      ceres_problem.AddResidualBlock(
          new RowsReprojectionCost(lenses[l], seen.img, seen.sigma_px,
                                   RowTime(problem.readout_s, seen.img.y(), lenses[l].height)),
          loss, blocks.poses[c].data(), problem.points[p].data(), blocks.twists[c].data());
    else if (options.free.Count() == 0)
      ceres_problem.AddResidualBlock(new ReprojectionCost(lenses[l], seen.img, seen.sigma_px), loss,
                                     blocks.poses[c].data(), problem.points[p].data());
    else
      ceres_problem.AddResidualBlock(new IntrinsicsReprojectionCost(lenses[l], seen.img, seen.sigma_px), loss,
                                     blocks.poses[c].data(), problem.points[p].data(),
                                     blocks.lenses[l].data());
    blocks.used_camera[c] = blocks.used_point[p] = blocks.used_lens[l] = true;
  }
}

ceres::LinearSolverType SolverFor(const BundleOptions& options, int free_cameras) {
  if (options.solver == BundleSolver::kSparse) return ceres::SPARSE_SCHUR;
  const bool dense = options.solver == BundleSolver::kBySize ? free_cameras <= options.dense_cameras
                                                             : options.solver == BundleSolver::kDense;
  return dense ? ceres::DENSE_SCHUR : ceres::ITERATIVE_SCHUR;
}

ceres::Solver::Summary Solve(std::vector<CameraModel>& lenses, BundleProblem& problem,
                             const std::vector<bool>& fixed, int iterations, int iterations_before,
                             const BundleOptions& options) {
  ceres::Problem::Options ownership;
  ownership.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ownership.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ceres::Problem ceres_problem(ownership);
  std::unique_ptr<ceres::LossFunction> loss = std::make_unique<ceres::HuberLoss>(options.huber_sigmas);
  if (options.cauchy_scales > 0)
    loss = std::make_unique<ceres::CauchyLoss>(
        options.cauchy_scales * std::clamp(ErrorScale(lenses, problem), kLeastErrorScale, 1.0));
  PoseManifold manifold;
  std::vector<IntrinsicsManifold> lens_manifolds;
  for (const CameraModel& lens : lenses) lens_manifolds.emplace_back(lens, options.free);

  Blocks blocks;
  for (const Rigid3& pose : problem.cam_from_world) blocks.poses.push_back(ToBlock(pose));
  for (const CameraModel& lens : lenses) blocks.lenses.push_back(ToBlock(lens));
  blocks.twists.assign(blocks.poses.size(), Twist::Zero());
  for (std::size_t c = 0; c < blocks.poses.size(); ++c)
    if (const RowsMotion* rows = RowsOf(problem, static_cast<int>(c))) blocks.twists[c] = rows->twist;
  blocks.used_camera.resize(blocks.poses.size());
  blocks.used_lens.resize(lenses.size());
  blocks.used_point.resize(problem.points.size());
  AddObservations(lenses, problem, blocks, loss.get(), options, ceres_problem);
  auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
  int free_cameras = 0;
  for (std::size_t c = 0; c < blocks.poses.size(); ++c) {
    if (!blocks.used_camera[c]) continue;
    ceres_problem.SetManifold(blocks.poses[c].data(), &manifold);
    if (fixed[c]) ceres_problem.SetParameterBlockConstant(blocks.poses[c].data());
    free_cameras += !fixed[c];
    ordering->AddElementToGroup(blocks.poses[c].data(), 1);
    if (const RowsMotion* rows = RowsOf(problem, static_cast<int>(c))) {
      ceres_problem.AddResidualBlock(new TwistPriorCost(rows->prior, rows->prior_sigma), nullptr,
                                     blocks.twists[c].data());
      ordering->AddElementToGroup(blocks.twists[c].data(), 1);
      ++free_cameras;  // a twist has as many unknowns as a pose
    }
  }
  const bool with_lenses = options.free.Count() > 0;
  for (std::size_t l = 0; l < lenses.size() && with_lenses; ++l) {
    if (!blocks.used_lens[l]) continue;
    ceres_problem.SetManifold(blocks.lenses[l].data(), &lens_manifolds[l]);
    ordering->AddElementToGroup(blocks.lenses[l].data(), 1);
  }
  for (std::size_t p = 0; p < std::min(problem.known.size(), problem.points.size()); ++p)
    if (blocks.used_point[p] && problem.known[p])
      ceres_problem.SetParameterBlockConstant(problem.points[p].data());
  for (std::size_t p = 0; p < problem.points.size(); ++p)
    if (blocks.used_point[p]) ordering->AddElementToGroup(problem.points[p].data(), 0);

  ceres::Solver::Options solver = SilentSolver(iterations);
  solver.linear_solver_type = SolverFor(options, free_cameras);
  // SCHUR_JACOBI visits every pair of cameras that share a point. Points here are seen by dozens of cameras,
  // so it costs more than the iterations that it saves.
  solver.preconditioner_type = ceres::JACOBI;
  solver.linear_solver_ordering = ordering;
  solver.function_tolerance = options.function_tolerance;
  Watcher watcher(options, iterations_before);
  if (options.stop || options.progress) solver.callbacks.push_back(&watcher);
  ceres::Solver::Summary summary;
  ceres::Solve(solver, &ceres_problem, &summary);
  for (std::size_t c = 0; c < blocks.poses.size(); ++c)
    if (blocks.used_camera[c] && !fixed[c]) {
      problem.cam_from_world[c] = FromBlock(blocks.poses[c].data());
      problem.cam_from_world[c].rotation.normalize();
    }
  for (std::size_t c = 0; c < blocks.poses.size(); ++c)
    if (blocks.used_camera[c] && RowsOf(problem, static_cast<int>(c)))
      problem.rows[c]->twist = blocks.twists[c];
  for (std::size_t l = 0; l < lenses.size() && with_lenses; ++l)
    if (blocks.used_lens[l]) lenses[l] = WithIntrinsics(lenses[l], blocks.lenses[l].data());
  return summary;
}

int MarkOutliers(const std::vector<CameraModel>& lenses, BundleProblem& problem,
                 const BundleOptions& options) {
  double gate_sigmas = options.gate_sigmas;
  if (options.gate_scales > 0)
    gate_sigmas =
        std::min(gate_sigmas, options.gate_scales * std::max(kLeastErrorScale, ErrorScale(lenses, problem)));
  int outliers = 0;
  for (BundleObservation& seen : problem.observations) {
    seen.outlier = SquaredErrorSigmas(lenses, problem, seen) > gate_sigmas * gate_sigmas;
    outliers += seen.outlier;
  }
  return outliers;
}

void FindLeastKept(const BundleProblem& problem, BundleSummary& summary) {
  std::vector<int> all(problem.cam_from_world.size(), 0), kept(all.size(), 0);
  for (const BundleObservation& seen : problem.observations) {
    ++all[At(seen.camera)];
    kept[At(seen.camera)] += !seen.outlier;
  }
  for (std::size_t c = 0; c < all.size(); ++c) {
    const double share = all[c] > 0 ? static_cast<double>(kept[c]) / all[c] : 1;
    if (all[c] == 0 || (summary.least_kept_camera >= 0 && share >= summary.least_kept)) continue;
    summary.least_kept = share;
    summary.least_kept_camera = static_cast<int>(c);
  }
}

// Scales the world about the only fixed camera until the farthest other camera is as far as it was.
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
  for (std::optional<RowsMotion>& rows : problem.rows)
    if (rows) rows->twist.tail<3>() *= scale;
  for (Vector3d& point : problem.points) point = origin + scale * (point - origin);
}

}  // namespace

double ErrorScale(const std::vector<CameraModel>& lenses, const BundleProblem& problem) {
  std::vector<double> lengths;
  for (const BundleObservation& seen : problem.observations)
    if (!seen.outlier) lengths.push_back(std::sqrt(SquaredErrorSigmas(lenses, problem, seen)));
  return Median(std::move(lengths)) / kMedianLength;
}

double SquaredErrorSigmas(const std::vector<CameraModel>& lenses, const BundleProblem& problem,
                          const BundleObservation& seen) {
  const CameraModel& lens = lenses[LensOf(problem, seen.camera)];
  Vector3d in_cam = problem.cam_from_world[At(seen.camera)] * problem.points[At(seen.point)];
  if (const RowsMotion* rows = RowsOf(problem, seen.camera))
    in_cam = PointAfter(rows->twist, in_cam, RowTime(problem.readout_s, seen.img.y(), lens.height));
  const auto img = lens.ImgFromCam(in_cam);
  return img ? (*img - seen.img).squaredNorm() / (seen.sigma_px * seen.sigma_px) : 1e8;
}

BundleSummary AdjustBundle(const CameraModel& camera, BundleProblem& problem, const BundleOptions& options) {
  std::vector<CameraModel> lenses{camera};
  return AdjustBundle(lenses, problem, options);
}

BundleSummary AdjustBundle(std::vector<CameraModel>& lenses, BundleProblem& problem,
                           const BundleOptions& options) {
  BundleSummary summary;
  if (problem.cam_from_world.empty() || problem.observations.empty()) {
    summary.message = "nothing to adjust";
    return summary;
  }
  std::vector<bool> fixed = problem.fixed;
  fixed.resize(problem.cam_from_world.size(), false);
  const bool points_known =
      std::find(problem.known.begin(), problem.known.end(), true) != problem.known.end();
  if (!points_known && std::find(fixed.begin(), fixed.end(), true) == fixed.end()) fixed[0] = true;
  std::vector<Vector3d> centers_before;
  for (const Rigid3& pose : problem.cam_from_world) centers_before.push_back(pose.OriginInSource());

  const BundleProblem before = problem;
  const std::vector<CameraModel> lenses_before = lenses;
  for (CameraModel& lens : lenses) lens = WithRoomFor(options.free, lens);
  summary.initial_rms_sigmas = Rms(lenses, problem);
  auto solution = Solve(lenses, problem, fixed, options.robust_iterations, 0, options);
  summary.iterations = static_cast<int>(solution.iterations.size());
  summary.usable = solution.IsSolutionUsable();
  // A solution that was stopped does not show which observations are wrong.
  const bool stopped = options.stop && *options.stop;
  if (!stopped) summary.outliers = MarkOutliers(lenses, problem, options);
  if (summary.usable && options.iterations > 0 && !stopped) {
    solution = Solve(lenses, problem, fixed, options.iterations, summary.iterations, options);
    summary.outliers = MarkOutliers(lenses, problem, options);
    summary.iterations += static_cast<int>(solution.iterations.size());
    summary.usable = solution.IsSolutionUsable();
  }
  summary.settled = solution.termination_type == ceres::CONVERGENCE;
  summary.message = solution.message;
  FindLeastKept(problem, summary);
  if (const auto seen = static_cast<int>(problem.observations.size()); 2 * summary.outliers > seen) {
    summary.usable = false;
    summary.message = fmt::format("only {} of {} observations agree", seen - summary.outliers, seen);
  }
  if (!summary.usable) {
    problem = before;
    lenses = lenses_before;
    return summary;
  }
  if (!points_known && std::count(fixed.begin(), fixed.end(), true) == 1)
    RestoreScale(problem, At(std::find(fixed.begin(), fixed.end(), true) - fixed.begin()), centers_before);
  summary.final_rms_sigmas = Rms(lenses, problem);
  return summary;
}

}  // namespace ulf::tracking
