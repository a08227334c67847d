#include "tracking/estimation/lens_evidence.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/at.h"
#include "core/base/quantile.h"
#include "core/geometry/similarity3.h"
#include "core/geometry/small_matrices.h"
#include "tracking/estimation/absolute_pose.h"
#include "tracking/estimation/residuals.h"

namespace ulf::tracking {
namespace {

constexpr std::size_t kLensMinCameras = 3,
                      kLensMinObservations = 100;  // fewer tell nothing of a lens. Guessed
constexpr double kLensHuberSigmas = kSigmas95;     // beyond it an error counts less
constexpr double kLensFunctionTolerance = 1e-7;    // relative change of the cost that ends a fit. Guessed
// A parameter stays free that differs by more than so many of its sigmas (and see kStrongEvidence).
constexpr double kLensMovedSigmas = 3;

// Returns twice the negative log-likelihood up to a constant: Huber's loss of errors in units of `scale`.
double RobustCost(const std::vector<CameraModel>& lenses, const BundleProblem& problem, double scale,
                  double huber_sigmas) {
  double cost = 0;
  for (const BundleObservation& seen : problem.observations)
    cost += HuberCost(SquaredErrorSigmas(lenses, problem, seen) / (scale * scale), huber_sigmas);
  return cost;
}

// Covariance of the free intrinsics for unit-variance errors: the inverse of the normal equations after
// points, then poses are eliminated. The world's position, orientation and scale do not touch the lens; a
// little damping makes them solvable. Errors beyond `gate_sigmas` are left out.
Eigen::MatrixXd LensCovariance(const CameraModel& lens, const BundleProblem& problem,
                               const FreeIntrinsics& free, double gate_sigmas) {
  constexpr double kDamping = 1e-9;
  const int cameras = static_cast<int>(problem.cam_from_world.size());
  const int own = free.Count(), size = 6 * cameras + own;
  const Eigen::MatrixXd directions = FreeDirections(lens, free);
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(size, size);
  std::vector<std::vector<const BundleObservation*>> by_point(problem.points.size());
  for (const BundleObservation& seen : problem.observations) by_point[At(seen.point)].push_back(&seen);
  const IntrinsicsBlock block = ToBlock(lens);
  for (std::size_t p = 0; p < by_point.size(); ++p) {
    if (by_point[p].size() < 2) continue;
    Eigen::Matrix3d by_itself = Eigen::Matrix3d::Zero();
    std::vector<std::pair<int, Eigen::Matrix<double, 6, 3>>> cross;
    Eigen::MatrixXd lens_cross = Eigen::MatrixXd::Zero(own, 3);
    for (const BundleObservation* seen : by_point[p]) {
      const IntrinsicsReprojectionCost cost(lens, seen->img, seen->sigma_px);
      const PoseBlock pose = ToBlock(problem.cam_from_world[At(seen->camera)]);
      const double* parameters[] = {pose.data(), problem.points[p].data(), block.data()};
      Eigen::Vector2d error;
      Eigen::Matrix<double, 2, 7, Eigen::RowMajor> by_pose;
      Eigen::Matrix<double, 2, 3, Eigen::RowMajor> by_point_j;
      Eigen::Matrix<double, 2, 9, Eigen::RowMajor> by_lens;
      double* jacobians[] = {by_pose.data(), by_point_j.data(), by_lens.data()};
      cost.Evaluate(parameters, error.data(), jacobians);
      if (error.norm() > gate_sigmas) continue;
      const Eigen::Matrix<double, 2, 6> j = by_pose.leftCols<6>();
      const Eigen::MatrixXd k = by_lens * directions;
      const int at = 6 * seen->camera;
      normal.block<6, 6>(at, at) += j.transpose() * j;
      normal.block(at, 6 * cameras, 6, own) += j.transpose() * k;
      normal.block(6 * cameras, at, own, 6) += k.transpose() * j;
      normal.bottomRightCorner(own, own) += k.transpose() * k;
      by_itself += by_point_j.transpose() * by_point_j;
      cross.emplace_back(at, j.transpose() * by_point_j);
      lens_cross += k.transpose() * by_point_j;
    }
    const auto invertible = InverseOf(by_itself);
    if (!invertible) continue;
    const Eigen::Matrix3d& inverse = *invertible;
    for (const auto& [a, cross_a] : cross) {
      const Eigen::Matrix<double, 6, 3> left = cross_a * inverse;
      for (const auto& [b, cross_b] : cross) normal.block<6, 6>(a, b) -= left * cross_b.transpose();
      normal.block(a, 6 * cameras, 6, own) -= left * lens_cross.transpose();
      normal.block(6 * cameras, a, own, 6) -= lens_cross * left.transpose();
    }
    normal.bottomRightCorner(own, own) -= lens_cross * inverse * lens_cross.transpose();
  }
  Eigen::MatrixXd poses = normal.topLeftCorner(6 * cameras, 6 * cameras);
  for (int i = 0; i < 6 * cameras; ++i) poses(i, i) += kDamping * poses(i, i) + kDamping;
  const Eigen::MatrixXd to_lens = normal.topRightCorner(6 * cameras, own);
  // Column by column and lazily, as bundle_uncertainty.cpp explains.
  const Eigen::LDLT<Eigen::MatrixXd> solver(poses);
  Eigen::MatrixXd solved(to_lens.rows(), own);
  for (int i = 0; i < own; ++i) solved.col(i) = solver.solve(Eigen::VectorXd(to_lens.col(i)));
  const Eigen::MatrixXd reduced =
      normal.bottomRightCorner(own, own) - to_lens.transpose().lazyProduct(solved);
  const Eigen::FullPivLU<Eigen::MatrixXd> lu(reduced);
  if (!lu.isInvertible()) return Eigen::MatrixXd::Constant(own, own, std::numeric_limits<double>::infinity());
  return lu.inverse();
}

void AddSigmas(const BundleProblem& solved, double scale, double gate_sigmas, LensEstimate& fit) {
  const Eigen::MatrixXd covariance = LensCovariance(fit.lens, solved, fit.free, gate_sigmas);
  // Rounding makes the variance of an undetermined number negative.
  const auto sigma = [&](int i) {
    return covariance(i, i) > 0 ? scale * std::sqrt(covariance(i, i))
                                : std::numeric_limits<double>::infinity();
  };
  int at = 0;
  if (fit.free.focal) fit.focal_sigma_px = fit.lens.MeanFocalPx() * sigma(at++);
  if (fit.free.principal_point) {
    fit.principal_point_sigma_px = std::max(sigma(at), sigma(at + 1));
    at += 2;
  }
  if (fit.free.k1) fit.k1_sigma = sigma(at++);
  if (fit.free.k2) fit.k2_sigma = sigma(at++);
}

std::vector<Eigen::Vector3d> CentersOf(const BundleProblem& problem) {
  std::vector<Eigen::Vector3d> centers;
  for (const Rigid3& cam_from_world : problem.cam_from_world)
    centers.push_back(cam_from_world.OriginInSource());
  return centers;
}

double CentersMoved(const BundleProblem& before, const BundleProblem& after) {
  const std::vector<Eigen::Vector3d> from = CentersOf(before), to = CentersOf(after);
  const auto aligned = AlignPoints(from, to);
  if (!aligned) return 0;
  double squares = 0;
  for (std::size_t i = 0; i < from.size(); ++i) squares += (*aligned * from[i] - to[i]).squaredNorm();
  std::vector<double> distances;
  for (const BundleObservation& seen : after.observations)
    distances.push_back((after.cam_from_world[At(seen.camera)] * after.points[At(seen.point)]).norm());
  return std::sqrt(squares / static_cast<double>(from.size())) / std::max(1e-9, Median(std::move(distances)));
}

BundleOptions Options(const LensEvidenceOptions& evidence, const FreeIntrinsics& free) {
  return {.robust_iterations = evidence.iterations,
          .iterations = 0,
          .stop = evidence.stop,
          .free = free,
          .function_tolerance = kLensFunctionTolerance};
}

// Returns whether the number that `larger` frees beyond `smaller` has moved by more than `sigmas`.
bool HasMoved(const LensEstimate& larger, const FreeIntrinsics& smaller, const CameraModel& from,
              double sigmas) {
  const CameraModel& to = larger.lens;
  if (larger.free.focal && !smaller.focal)
    return std::abs(to.MeanFocalPx() - from.MeanFocalPx()) > sigmas * larger.focal_sigma_px;
  if (larger.free.principal_point && !smaller.principal_point)
    return std::hypot(to.cx - from.cx, to.cy - from.cy) > sigmas * larger.principal_point_sigma_px;
  const bool k1 = larger.free.k1 && !smaller.k1;
  return std::abs(to.coefficients[k1 ? 0 : 1] - from.coefficients[k1 ? 0 : 1]) >
         sigmas * (k1 ? larger.k1_sigma : larger.k2_sigma);
}

// A part of a problem, adjusted under the given lens or with some of it free.
struct Fitted {
  FreeIntrinsics free;
  std::vector<CameraModel> lens;  // one
  BundleProblem problem;
  double scale = 1;  // of its errors, in their deviations

  static std::optional<Fitted> AsGiven(const CameraModel& given, const BundleProblem& part,
                                       const LensEvidenceOptions& options) {
    if (part.cam_from_world.size() < kLensMinCameras || part.observations.size() < kLensMinObservations)
      return std::nullopt;
    Fitted base{{}, {given}, part};
    return AdjustBundle(base.lens, base.problem, Options(options, {})).usable ? std::optional(std::move(base))
                                                                              : std::nullopt;
  }
  // Fits from here, with `part`'s observations.
  std::optional<Fitted> With(const FreeIntrinsics& freed, const BundleProblem& part,
                             const LensEvidenceOptions& options) const {
    Fitted fit{freed, lens, part};
    fit.problem.cam_from_world = problem.cam_from_world;
    fit.problem.points = problem.points;
    if (!AdjustBundle(fit.lens, fit.problem, Options(options, freed)).usable) return std::nullopt;
    fit.scale = std::max(1e-6, ErrorScale(fit.lens, fit.problem));
    return fit;
  }
  double GainOver(const Fitted& base, double unit) const {
    return RobustCost(base.lens, base.problem, unit, kLensHuberSigmas) -
           RobustCost(lens, problem, unit, kLensHuberSigmas) -
           free.Count() * std::log(2.0 * static_cast<double>(problem.observations.size()));
  }
  LensEstimate Estimate(const Fitted& base, double unit) const {
    LensEstimate estimate{free, lens.front()};
    estimate.gain = GainOver(base, unit);
    AddSigmas(problem, scale, 2 * kLensHuberSigmas, estimate);
    estimate.centers_moved = CentersMoved(base.problem, problem);
    return estimate;
  }
};

}  // namespace

double DistortionAtCorner(const CameraModel& lens) {
  const double x = std::max(lens.cx, lens.width - lens.cx) / lens.fx;
  const double y = std::max(lens.cy, lens.height - lens.cy) / lens.fy;
  const double squared = x * x + y * y;
  return lens.coefficients[0] * squared + lens.coefficients[1] * squared * squared;
}

bool IsPlausible(const CameraModel& fitted, const CameraModel& given) {
  constexpr double kMostPincushion = 0.03, kLonger = 1.05;  // beyond the given lens's; guessed
  return fitted.MeanFocalPx() < kLonger * given.MeanFocalPx() ||
         DistortionAtCorner(fitted) < std::max(0.0, DistortionAtCorner(given)) + kMostPincushion;
}

BundleProblem PartForLens(const BundleProblem& problem, int lens, const LensEvidenceOptions& options) {
  std::vector<int> of_lens;
  std::vector<bool> observed(problem.cam_from_world.size());
  for (const BundleObservation& seen : problem.observations)
    if (!seen.outlier) observed[At(seen.camera)] = true;
  for (int c = 0; c < static_cast<int>(problem.cam_from_world.size()); ++c)
    if (observed[At(c)] && (problem.lens.empty() ? 0 : problem.lens[At(c)]) == lens) of_lens.push_back(c);
  BundleProblem part;
  std::vector<int> camera_of(problem.cam_from_world.size(), -1);
  const std::size_t count = std::min(of_lens.size(), At(options.max_cameras));
  for (std::size_t i = 0; i < count; ++i) {
    const int c = of_lens[i * of_lens.size() / count];
    camera_of[At(c)] = static_cast<int>(part.cam_from_world.size());
    part.cam_from_world.push_back(problem.cam_from_world[At(c)]);
  }
  part.fixed.assign(part.cam_from_world.size(), false);
  if (!part.fixed.empty()) part.fixed[0] = true;
  std::vector<int> seen_by(problem.points.size(), 0);
  const auto takes_part = [&](const BundleObservation& seen) {
    return !seen.outlier && camera_of[At(seen.camera)] >= 0;
  };
  for (const BundleObservation& seen : problem.observations) seen_by[At(seen.point)] += takes_part(seen);
  std::vector<int> order;
  for (int p = 0; p < static_cast<int>(seen_by.size()); ++p)
    if (seen_by[At(p)] >= 2) order.push_back(p);
  std::ranges::stable_sort(order, [&](int a, int b) { return seen_by[At(a)] > seen_by[At(b)]; });
  if (order.size() > At(options.max_points)) order.resize(At(options.max_points));
  std::vector<int> point_of(problem.points.size(), -1);
  for (const int p : order) {
    point_of[At(p)] = static_cast<int>(part.points.size());
    part.points.push_back(problem.points[At(p)]);
  }
  for (const BundleObservation& seen : problem.observations) {
    const int p = point_of[At(seen.point)];
    if (p >= 0 && takes_part(seen))
      part.observations.push_back({camera_of[At(seen.camera)], p, seen.img, seen.sigma_px, false});
  }
  return part;
}

std::vector<LensEstimate> FitLens(const CameraModel& given, const BundleProblem& part,
                                  const std::vector<FreeIntrinsics>& choices,
                                  const LensEvidenceOptions& options) {
  const auto base = Fitted::AsGiven(given, part, options);
  if (!base) return {};
  std::vector<Fitted> solved;
  for (const FreeIntrinsics& free : choices)
    if (auto fit = base->With(free, part, options)) solved.push_back(std::move(*fit));
  // Gains are compared, so they are counted in one unit: the noise that the best of them leaves.
  double scale = std::numeric_limits<double>::infinity();
  for (const Fitted& fit : solved) scale = std::min(scale, fit.scale);
  std::vector<LensEstimate> fits;
  for (const Fitted& fit : solved) fits.push_back(fit.Estimate(*base, scale));
  return fits;
}

std::optional<LensEstimate> ChooseLens(const CameraModel& given, const BundleProblem& part,
                                       const LensEvidenceOptions& options, std::vector<LensTrial>* trials) {
  const auto base = Fitted::AsGiven(given, part, options);
  if (!base) return std::nullopt;
  std::optional<Fitted> best;
  for (const auto step :
       {&FreeIntrinsics::focal, &FreeIntrinsics::k1, &FreeIntrinsics::principal_point, &FreeIntrinsics::k2}) {
    const FreeIntrinsics free = best ? best->free : FreeIntrinsics{};
    FreeIntrinsics next = free;
    next.*step = true;
    auto solved = base->With(next, part, options);
    if (!solved) break;
    const LensEstimate fit = solved->Estimate(*base, solved->scale);
    const double gain_before = best ? best->GainOver(*base, solved->scale) : 0;
    const bool moved = HasMoved(fit, free, best ? best->lens.front() : given, kLensMovedSigmas);
    const bool strong = moved && fit.gain > gain_before + kStrongEvidence;
    const bool plausible = IsPlausible(fit.lens, given);
    const LensTrial trial{fit, gain_before, moved, strong && plausible, plausible};
    if (trials) trials->push_back(trial);
    if (strong && !plausible) return std::nullopt;
    if (trial.kept) best = std::move(solved);
  }
  return best ? std::optional(best->Estimate(*base, best->scale)) : std::nullopt;
}

}  // namespace ulf::tracking
