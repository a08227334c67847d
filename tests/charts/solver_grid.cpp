#include "tests/charts/solver_grid.h"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "core/base/host_time.h"
#include "core/base/quantile.h"
#include "tests/support/floors.h"
#include "tests/tracking/scenes/geometry_scene.h"
#include "tracking/estimation/sampling.h"

namespace ulf::test {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

CameraModel Camera() { return CameraModel::FromOpenCv(640, 480, 525, 525, 320, 240, Distortion::kNone, {}); }

double SecondsSince(double start_s) { return ThreadCpuSeconds() - start_s; }

// Points in the (first) camera, in its picture.
class Points {
 public:
  Points(const Geometry& geometry, Draw& draw)
      : geometry_(geometry),
        draw_(draw),
        normal_(Vector3d(draw.Uniform(-0.5, 0.5), draw.Uniform(-0.5, 0.5), 1).normalized()) {}
  Vector3d Next() {
    const Vector2d img(draw_.Uniform(0, 640), draw_.Uniform(0, 480));
    const Vector3d ray = *Camera().RayFromImg(img);
    if (geometry_.relief < 0) return draw_.Uniform(geometry_.nearest, geometry_.farthest) / ray.z() * ray;
    const double depth = geometry_.nearest * normal_.z() / normal_.dot(ray);
    return (depth + draw_.Uniform(-1, 1) * geometry_.relief) * ray;
  }

 private:
  const Geometry& geometry_;
  Draw& draw_;
  Vector3d normal_;
};

Vector2d Jitter(Draw& draw, double noise_px) { return {draw.Normal(noise_px), draw.Normal(noise_px)}; }
Vector2d Anywhere(Draw& draw) { return {draw.Uniform(0, 640), draw.Uniform(0, 480)}; }
int OutliersFor(const Geometry& geometry, double share) {
  return static_cast<int>(std::lround(geometry.inliers * share / (1 - share)));
}

struct AbsoluteProblem {
  Rigid3 cam_from_world;
  std::vector<PointObservation> matches;
  std::vector<Vector3d> points;  // of the inliers, in the camera
};

AbsoluteProblem MakeAbsolute(const Geometry& geometry, double noise_px, double outliers, unsigned seed) {
  Draw draw(seed);
  AbsoluteProblem problem;
  problem.cam_from_world = RandomPose(draw, 2.5, 3);
  const Rigid3 world_from_cam = problem.cam_from_world.Inverse();
  Points points(geometry, draw);
  const int wrong = OutliersFor(geometry, outliers);
  for (int i = 0; i < geometry.inliers + wrong; ++i) {
    const Vector3d in_cam = points.Next();
    PointObservation seen{world_from_cam * in_cam, *Camera().ImgFromCam(in_cam), std::max(noise_px, 0.1)};
    seen.img = i < geometry.inliers ? Vector2d(seen.img + Jitter(draw, noise_px)) : Anywhere(draw);
    problem.matches.push_back(seen);
    if (i < geometry.inliers) problem.points.push_back(in_cam);
  }
  return problem;
}

struct RelativeProblem {
  Rigid3 second_from_first;
  std::vector<RayPair> pairs;
};

RelativeProblem MakeRelative(const Geometry& geometry, double noise_px, double outliers, unsigned seed) {
  Draw draw(seed);
  const CameraModel camera = Camera();
  RelativeProblem problem;
  Vector3d direction = draw.Direction();
  direction.z() *= geometry.forward ? 0 : 0.3;
  if (geometry.forward) direction = Vector3d(0.1 * direction.x(), 0.1 * direction.y(), -1);
  problem.second_from_first = {
      Eigen::Quaterniond(Eigen::AngleAxisd(draw.Uniform(0.01, 0.1), draw.Direction())),
      geometry.baseline * direction.normalized()};
  Points points(geometry, draw);
  const int wrong = OutliersFor(geometry, outliers);
  while (static_cast<int>(problem.pairs.size()) < geometry.inliers + wrong) {
    const Vector3d in_first = points.Next();
    const auto second = camera.ImgFromCam(problem.second_from_first * in_first);
    if (!second || !camera.Contains(*second)) continue;
    const bool right = static_cast<int>(problem.pairs.size()) < geometry.inliers;
    const auto first_ray = camera.RayFromImg(*camera.ImgFromCam(in_first) + Jitter(draw, noise_px));
    const auto second_ray =
        camera.RayFromImg(right ? Vector2d(*second + Jitter(draw, noise_px)) : Anywhere(draw));
    problem.pairs.push_back({*first_ray, *second_ray});
  }
  return problem;
}

double LandingErrorPx(const AbsoluteProblem& problem, const Rigid3& cam_from_world) {
  const Rigid3 estimated_from_true = cam_from_world * problem.cam_from_world.Inverse();
  double squared = 0;
  for (const Vector3d& point : problem.points) {
    const auto img = Camera().ImgFromCam(estimated_from_true * point);
    if (!img) return std::numeric_limits<double>::infinity();
    squared += (*img - *Camera().ImgFromCam(point)).squaredNorm();
  }
  return std::sqrt(squared / static_cast<double>(problem.points.size()));
}

std::optional<Rigid3> Estimate(const std::vector<PointObservation>& matches, const AbsoluteSolver& solver,
                               const SamplingOptions& sampling) {
  const CameraModel camera = Camera();
  std::vector<Vector3d> rays;
  for (const PointObservation& match : matches) rays.push_back(*camera.RayFromImg(match.img));
  const auto solve = [&](const std::vector<int>& sample) {
    std::vector<Vector3d> points, sample_rays;
    for (const int i : sample) {
      points.push_back(matches[static_cast<std::size_t>(i)].point_in_world);
      sample_rays.push_back(rays[static_cast<std::size_t>(i)]);
    }
    return solver.solve(points, sample_rays);
  };
  const auto residual2 = [&](const Rigid3& pose, int i) {
    const PointObservation& match = matches[static_cast<std::size_t>(i)];
    const auto img = camera.ImgFromCam(pose * match.point_in_world);
    return img ? (*img - match.img).squaredNorm() : std::numeric_limits<double>::infinity();
  };
  const auto improve = [&](const Rigid3& pose, const std::vector<int>& inliers) -> std::optional<Rigid3> {
    if (inliers.size() < 6) return std::nullopt;
    std::vector<PointObservation> used;
    for (const int i : inliers) {
      used.push_back(matches[static_cast<std::size_t>(i)]);
      used.back().sigma_px = sampling.threshold / 2.45;
    }
    const auto refined = RefinePose(camera, used, pose, {.rounds = 1, .max_iterations = 5});
    return refined ? std::optional(refined->cam_from_world) : std::nullopt;
  };
  const auto found = SampleConsensus<Rigid3>(static_cast<int>(matches.size()), solver.sample_size, solve,
                                             residual2, improve, sampling);
  return found ? std::optional(found->model) : std::nullopt;
}

// The best of the essential matrix's four motions is told by the truth: which one it is costs nothing and
// depends on no solver.
std::optional<Matrix3d> Estimate(const std::vector<RayPair>& pairs, const EssentialSolver& solver,
                                 const SamplingOptions& sampling) {
  const auto solve = [&](const std::vector<int>& sample) {
    std::vector<Vector3d> first, second;
    for (const int i : sample) {
      first.push_back(pairs[static_cast<std::size_t>(i)].first);
      second.push_back(pairs[static_cast<std::size_t>(i)].second);
    }
    return solver.solve(first, second);
  };
  const auto residual2 = [&](const Matrix3d& essential, int i) {
    const double error = EpipolarError(essential, pairs[static_cast<std::size_t>(i)]);
    return error * error;
  };
  const auto improve = [](const Matrix3d&, const std::vector<int>&) { return std::optional<Matrix3d>(); };
  const auto found = SampleConsensus<Matrix3d>(static_cast<int>(pairs.size()), solver.sample_size, solve,
                                               residual2, improve, sampling);
  return found ? std::optional(found->model) : std::nullopt;
}

constexpr double kNothing = std::numeric_limits<double>::infinity();

// Of a trial; `error` is what a failure is told by.
struct TrialError {
  double error = kNothing, rotation_deg = kNothing, position = kNothing;
};

TrialError MotionError(const Rigid3& truth, const Matrix3d& essential) {
  const Eigen::JacobiSVD<Matrix3d> svd(essential, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Matrix3d w;
  w << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  TrialError best;
  for (const Matrix3d& turn : {w, Matrix3d(w.transpose())})
    for (const double sign : {1.0, -1.0}) {
      Matrix3d rotation = svd.matrixU() * turn * svd.matrixV().transpose();
      rotation *= rotation.determinant() < 0 ? -1 : 1;
      const double turned = DegreesBetween(truth.rotation, Eigen::Quaterniond(rotation));
      const double aside = DegreesBetween(truth.translation, sign * svd.matrixU().col(2));
      if (std::max(turned, aside) < best.error) best = {std::max(turned, aside), turned, aside};
    }
  return best;
}

TrialError PoseError(const AbsoluteProblem& problem, const Geometry& geometry, const Rigid3& found) {
  const double aside = (found.OriginInSource() - problem.cam_from_world.OriginInSource()).norm();
  return {LandingErrorPx(problem, found), DegreesBetween(found.rotation, problem.cam_from_world.rotation),
          100 * aside / geometry.nearest};
}

// solve(seed) -> (TrialError, seconds)
template <typename Solve>
Outcome Collect(const Trials& trials, double failure, Solve&& solve) {
  Outcome outcome;
  std::vector<double> rotations, positions;
  for (int k = 0; k < trials.count; ++k) {
    const auto [error, seconds] = solve(trials.seed * 1000 + static_cast<unsigned>(k));
    outcome.ms += 1000 * seconds / trials.count;
    rotations.push_back(error.rotation_deg);
    positions.push_back(error.position);
    if (!(error.error <= failure)) outcome.failures += 1.0 / trials.count;
  }
  outcome.rotation_deg = Median(rotations);
  outcome.position = Median(positions);
  return outcome;
}

}  // namespace

Outcome RunTrials(const Geometry& geometry, const AbsoluteSolver& solver, const Trials& trials) {
  return Collect(trials, 3 + 2 * trials.noise_px, [&](unsigned seed) {
    const AbsoluteProblem problem = MakeAbsolute(geometry, trials.noise_px, trials.outliers, seed);
    const double start = ThreadCpuSeconds();
    const auto found = Estimate(problem.matches, solver,
                                {.threshold = 4, .max_iterations = trials.max_iterations, .seed = seed});
    const double seconds = SecondsSince(start);
    return std::pair(found ? PoseError(problem, geometry, *found) : TrialError{}, seconds);
  });
}

Outcome RunTrials(const Geometry& geometry, const EssentialSolver& solver, const Trials& trials) {
  return Collect(trials, 10, [&](unsigned seed) {
    const RelativeProblem problem = MakeRelative(geometry, trials.noise_px, trials.outliers, seed);
    const double start = ThreadCpuSeconds();
    const auto found =
        Estimate(problem.pairs, solver,
                 {.threshold = 1.5 / 525, .max_iterations = trials.max_iterations, .seed = seed});
    const double seconds = SecondsSince(start);
    return std::pair(found ? MotionError(problem.second_from_first, *found) : TrialError{}, seconds);
  });
}

Alone RunAlone(const Geometry& geometry, const AbsoluteSolver& solver, int count, unsigned seed) {
  Alone alone;
  for (int k = 0; k < count; ++k) {
    const AbsoluteProblem problem = MakeAbsolute(geometry, 0, 0, seed * 100000 + static_cast<unsigned>(k));
    std::vector<Vector3d> points, rays;
    for (std::size_t i = 0; i < static_cast<std::size_t>(solver.sample_size); ++i) {
      points.push_back(problem.matches[i].point_in_world);
      rays.push_back(problem.points[i].normalized());
    }
    const double start = ThreadCpuSeconds();
    const auto poses = solver.solve(points, rays);
    alone.us += 1e6 * SecondsSince(start) / count;
    const bool hit = std::any_of(poses.begin(), poses.end(), [&](const Rigid3& pose) {
      const double distance = problem.points[0].norm();
      return RotationAngle(pose.rotation * problem.cam_from_world.rotation.conjugate()) < 1e-3 &&
             (pose.translation - problem.cam_from_world.translation).norm() < 1e-3 * distance;
    });
    alone.misses += hit ? 0 : 1.0 / count;
  }
  return alone;
}

Alone RunAlone(const Geometry& geometry, const EssentialSolver& solver, int count, unsigned seed) {
  Alone alone;
  for (int k = 0; k < count; ++k) {
    const RelativeProblem problem = MakeRelative(geometry, 0, 0, seed * 100000 + static_cast<unsigned>(k));
    std::vector<Vector3d> first, second;
    for (std::size_t i = 0; i < static_cast<std::size_t>(solver.sample_size); ++i) {
      first.push_back(problem.pairs[i].first);
      second.push_back(problem.pairs[i].second);
    }
    const double start = ThreadCpuSeconds();
    const auto essentials = solver.solve(first, second);
    alone.us += 1e6 * SecondsSince(start) / count;
    Rigid3 unit = problem.second_from_first;
    unit.translation.normalize();
    const Matrix3d truth = EssentialFromPose(unit).normalized();
    const bool hit = std::any_of(essentials.begin(), essentials.end(), [&](const Matrix3d& essential) {
      const Matrix3d found = essential.normalized();
      return std::min((found - truth).norm(), (found + truth).norm()) < 1e-3;
    });
    alone.misses += hit ? 0 : 1.0 / count;
  }
  return alone;
}

}  // namespace ulf::test
