// Bundle adjustment: solvers by the number of views, and how many keyframes a local adjustment moves.
#include <algorithm>
#include <cmath>

#include "core/base/host_time.h"
#include "tests/measure/runner.h"
#include "tests/measure/table.h"
#include "tests/support/aligned_centres.h"
#include "tests/support/floors.h"
#include "tests/tracking/scenes/geometry_scene.h"
#include "tracking/estimation/bundle_adjustment.h"

namespace ulf::test {
namespace {

using Eigen::Vector3d;

constexpr double kNoise_px = 0.5, kOutliers = 0.02;
constexpr std::size_t kDenseUpTo = 120;  // free cameras, in the product

CameraModel BundleCamera() { return CameraModel::Pinhole(640, 480, 525); }

void Observe(BundleProblem& problem, Draw& draw, double seen_share) {
  const CameraModel camera = BundleCamera();
  for (std::size_t c = 0; c < problem.cam_from_world.size(); ++c)
    for (std::size_t p = 0; p < problem.points.size(); ++p) {
      if (draw.Uniform(0, 1) > seen_share) continue;
      auto img = camera.ImgFromCam(problem.cam_from_world[c] * problem.points[p]);
      if (!img || !camera.Contains(*img)) continue;
      *img += Eigen::Vector2d(draw.Normal(kNoise_px), draw.Normal(kNoise_px));
      if (draw.Uniform(0, 1) < kOutliers) *img += 20 * Eigen::Vector2d(draw.Normal(1), draw.Normal(1));
      problem.observations.push_back({static_cast<int>(c), static_cast<int>(p), *img, 1, false});
    }
}

Rigid3 Shaken(const Rigid3& pose, Draw& draw, double by) {
  Eigen::Matrix<double, 6, 1> twist;
  for (int i = 0; i < 6; ++i) twist(i) = draw.Normal(by);
  return Perturbed(pose, twist);
}

// A light field: every camera on a cap sees a fifth of 1,500 points.
BundleProblem LightFieldProblem(int views, unsigned seed) {
  Draw draw(seed);
  BundleProblem problem;
  for (int c = 0; c < views; ++c) {
    const double azimuth = draw.Uniform(-0.5, 0.5), elevation = draw.Uniform(-0.35, 0.35);
    const Vector3d center(std::sin(azimuth) * std::cos(elevation), std::sin(elevation),
                          -std::cos(azimuth) * std::cos(elevation));
    problem.cam_from_world.push_back(LookAt(1.5 * center, Vector3d::Zero(), Vector3d::UnitY()));
    problem.fixed.push_back(c < 2);
  }
  for (int p = 0; p < 1500; ++p) problem.points.push_back(0.5 * draw.Uniform(0.1, 1) * draw.Direction());
  Observe(problem, draw, 0.2);
  return problem;
}

double CentreErrorPct(const BundleProblem& found, const BundleProblem& truth) {
  constexpr double kDistance = 1.5;  // of what is seen, in both problems
  return 100 * AlignedCentreError(found.cam_from_world, truth.cam_from_world) / kDistance;
}

constexpr char kCentres[] = "all views at once, by their number", kPixels[] = "the same: reprojection";

void AddSolvers(Table& table, const Effort& effort) {
  const ChartAxis cost{"adjustment [s, CPU]", true};
  table.Panel(kCentres, cost, Log("centres are off by [% of the distance]"), {.compared = false});
  table.Panel(kPixels, cost, {"reprojection error [px RMS]"}, {.compared = false});
  for (const auto& [name, solver] : {std::pair{"dense Schur", BundleSolver::kDense},
                                     {"sparse Schur", BundleSolver::kSparse},
                                     {"conjugate gradients", BundleSolver::kIterative}})
    for (const int views : effort.Of(std::vector{20, 80}, {30, 60, 120, 240, 480})) {
      const bool dense_is_right = static_cast<std::size_t>(views) - 2 <= kDenseUpTo;
      const bool in_use = solver == (dense_is_right ? BundleSolver::kDense : BundleSolver::kIterative);
      for (const unsigned seed : effort.Seeds(3)) {
        const BundleProblem truth = LightFieldProblem(views, seed);
        BundleProblem problem = truth;
        Draw draw(seed + 500);
        for (std::size_t c = 2; c < problem.cam_from_world.size(); ++c)
          problem.cam_from_world[c] = Shaken(problem.cam_from_world[c], draw, 0.01);
        for (Vector3d& point : problem.points) point += 0.02 * draw.Direction();
        const double start = ThreadCpuSeconds();
        const BundleSummary summary = AdjustBundle(BundleCamera(), problem, {.solver = solver});
        const double seconds = ThreadCpuSeconds() - start;
        table.Add(kCentres, name, std::to_string(views), seconds, CentreErrorPct(problem, truth), in_use);
        table.Add(kPixels, name, std::to_string(views), seconds, summary.final_rms_sigmas, in_use);
      }
    }
}

// A camera that moves sideways along a wall, a keyframe each 0.1 at a distance of 1.5.
BundleProblem WallProblem(int keyframes, unsigned seed) {
  Draw draw(seed);
  BundleProblem problem;
  const double length = 0.1 * keyframes;
  for (int c = 0; c < keyframes; ++c) {
    const Vector3d center(0.1 * c, 0.05 * std::sin(0.4 * c), 0.05 * std::cos(0.3 * c) - 1.5);
    problem.cam_from_world.push_back(LookAt(center, center + Vector3d(0, 0, 1.5), Vector3d::UnitY()));
    problem.fixed.push_back(c < 2);
  }
  for (int p = 0; p < static_cast<int>(150 * length); ++p)
    problem.points.emplace_back(draw.Uniform(-1, length + 1), draw.Uniform(-0.7, 0.7),
                                draw.Uniform(-0.3, 0.3));
  Observe(problem, draw, 0.7);
  return problem;
}

// What keyframes up to `newest` see, as a problem in which the last `window` of them are free and those
// before them hold it; indices of cameras and points stay.
BundleProblem LocalProblem(const BundleProblem& all, int newest, int window) {
  constexpr int kHeld = 20;
  BundleProblem local = all;
  local.observations.clear();
  const int first_free = std::max(2, newest - window + 1), first_held = std::max(0, first_free - kHeld);
  std::vector<bool> seen_by_free(all.points.size());
  for (const BundleObservation& seen : all.observations)
    if (seen.camera >= first_free && seen.camera <= newest)
      seen_by_free[static_cast<std::size_t>(seen.point)] = true;
  for (const BundleObservation& seen : all.observations)
    if (seen.camera >= first_held && seen.camera <= newest &&
        seen_by_free[static_cast<std::size_t>(seen.point)])
      local.observations.push_back(seen);
  for (std::size_t c = 0; c < local.fixed.size(); ++c) local.fixed[c] = static_cast<int>(c) < first_free;
  return local;
}

struct Chain {
  double seconds = 0, centre_pct = 0, rms_px = 0;
};

// Keyframe after keyframe begins where the one before has come to, a little off, and is adjusted with its
// neighbours; points begin off by what their first views leave open.
Chain RunChain(int keyframes, int window, unsigned seed) {
  const BundleProblem truth = WallProblem(keyframes, seed);
  BundleProblem map = truth;
  Draw draw(seed + 500);
  for (Vector3d& point : map.points)
    point += Vector3d(draw.Normal(0.004), draw.Normal(0.004), draw.Normal(0.03));
  Chain chain;
  for (int newest = 2; newest < keyframes; ++newest) {
    const auto now = static_cast<std::size_t>(newest);
    const Rigid3 step = truth.cam_from_world[now] * truth.cam_from_world[now - 1].Inverse();
    map.cam_from_world[now] = Shaken(step * map.cam_from_world[now - 1], draw, 0.003);
    BundleProblem local = LocalProblem(map, newest, window);
    const double start = ThreadCpuSeconds();
    const BundleSummary summary =
        AdjustBundle(BundleCamera(), local, {.robust_iterations = 4, .iterations = 6});
    chain.seconds += ThreadCpuSeconds() - start;
    chain.rms_px = summary.final_rms_sigmas;
    map.cam_from_world = local.cam_from_world;
    map.points = local.points;
  }
  chain.centre_pct = CentreErrorPct(map, truth);
  return chain;
}

constexpr char kMoved[] = "keyframes along a wall, one after the other: how many are moved";
constexpr char kMovedPixels[] = "the same: reprojection at the end";

void AddWindows(Table& table, const Effort& effort) {
  constexpr int kInUse = 14;
  const int keyframes = effort.Of(20, 60);
  const ChartAxis cost{"local adjustment of a keyframe [ms, CPU]", true};
  table.Panel(kMoved, cost, Log("centres are off by [% of the distance]"));
  table.Panel(kMovedPixels, cost, {"reprojection error [px RMS]"});
  for (const int window : effort.Of(std::vector{3, 14}, {1, 2, 4, 7, 14, 28}))
    for (const unsigned seed : effort.Seeds(3)) {
      const Chain chain = RunChain(keyframes, window, seed);
      const double ms = 1000 * chain.seconds / (keyframes - 2);
      const std::string name = std::to_string(window);
      table.Add(kMoved, "keyframes moved", name, ms, chain.centre_pct, window == kInUse);
      table.Add(kMovedPixels, "keyframes moved", name, ms, chain.rms_px, window == kInUse);
    }
}

Chart MeasureBundles(const Effort& effort) {
  Table table;
  AddSolvers(table, effort);
  AddWindows(table, effort);
  return {.panels = table.panels()};
}

CHART(bundle_adjustment, MeasureBundles, "Bundle adjustment: solver, views and window", R"(Drawn scenes, 0.5
  px of noise and 2 % of outliers, sigma 1 px. Above: views on a cap that each see a fifth of 1,500 points,
  begun 1 % and 0.6 degrees off; ringed is the solver in use at that size. Below: drift over 60 keyframes
  when only the newest are moved, the twenty before them held. Three seeds; bars: lowest to highest.)");

}  // namespace
}  // namespace ulf::test
