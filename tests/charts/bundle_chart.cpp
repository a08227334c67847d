// Bundle adjustment: solvers by the number of views, and how many keyframes a local adjustment moves.
#include <algorithm>
#include <cmath>

#include "core/base/host_time.h"
#include "core/geometry/similarity3.h"
#include "tests/charts/makers.h"
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

// RMS distance of the centres after one similarity, % of the distance of what is seen.
double CentreErrorPct(const BundleProblem& found, const BundleProblem& truth, double distance) {
  std::vector<Vector3d> a, b;
  for (std::size_t c = 0; c < truth.cam_from_world.size(); ++c) {
    a.push_back(found.cam_from_world[c].OriginInSource());
    b.push_back(truth.cam_from_world[c].OriginInSource());
  }
  const auto aligned = AlignPoints(a, b);
  if (!aligned) return std::nan("");
  double squared = 0;
  for (std::size_t c = 0; c < a.size(); ++c) squared += (*aligned * a[c] - b[c]).squaredNorm();
  return 100 * std::sqrt(squared / static_cast<double>(a.size())) / distance;
}

void AddSolvers(Chart& chart, const ChartEffort& effort) {
  ChartPanel centres{"all views at once, by their number",
                     {"adjustment [s, CPU]", true},
                     {"centres are off by [% of the distance]", true},
                     {},
                     false};
  ChartPanel pixels{
      "the same: reprojection", {"adjustment [s, CPU]", true}, {"reprojection error [px RMS]"}, {}, false};
  for (const auto& [name, solver] : {std::pair{"dense Schur", BundleSolver::kDense},
                                     {"sparse Schur", BundleSolver::kSparse},
                                     {"conjugate gradients", BundleSolver::kIterative}})
    for (const int views : effort.Of(std::vector{20, 80}, {30, 60, 120, 240, 480})) {
      std::vector<double> seconds, errors, rms;
      for (const unsigned seed : effort.Of(std::vector{31u}, {31u, 32u, 33u})) {
        const BundleProblem truth = LightFieldProblem(views, seed);
        BundleProblem problem = truth;
        Draw draw(seed + 500);
        for (std::size_t c = 2; c < problem.cam_from_world.size(); ++c)
          problem.cam_from_world[c] = Shaken(problem.cam_from_world[c], draw, 0.01);
        for (Vector3d& point : problem.points) point += 0.02 * draw.Direction();
        const double start = ThreadCpuSeconds();
        const BundleSummary summary = AdjustBundle(BundleCamera(), problem, {.solver = solver});
        seconds.push_back(ThreadCpuSeconds() - start);
        errors.push_back(CentreErrorPct(problem, truth, 1.5));
        rms.push_back(summary.final_rms_sigmas);
      }
      const bool dense_is_right = static_cast<std::size_t>(views) - 2 <= kDenseUpTo;
      const bool in_use = solver == (dense_is_right ? BundleSolver::kDense : BundleSolver::kIterative);
      centres.points.push_back(
          {name, std::to_string(views), Spread::Of(seconds), Spread::Of(errors), in_use});
      pixels.points.push_back({name, std::to_string(views), Spread::Of(seconds), Spread::Of(rms), in_use});
    }
  chart.panels.push_back(centres);
  chart.panels.push_back(pixels);
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
  chain.centre_pct = CentreErrorPct(map, truth, 1.5);
  return chain;
}

void AddWindows(Chart& chart, const ChartEffort& effort) {
  const int keyframes = effort.Of(20, 60);
  ChartPanel panel{
      fmt::format("{} keyframes along a wall, one after the other: how many are moved", keyframes),
      {"local adjustment of a keyframe [ms, CPU]", true},
      {"centres are off by [% of the distance]", true},
      {}};
  ChartPanel pixels{"the same: reprojection at the end",
                    {"local adjustment of a keyframe [ms, CPU]", true},
                    {"reprojection error [px RMS]"},
                    {}};
  for (const int window : effort.Of(std::vector{3, 14}, {1, 2, 4, 7, 14, 28})) {
    std::vector<double> ms, centres, rms;
    for (const unsigned seed : effort.Of(std::vector{41u}, {41u, 42u, 43u})) {
      const Chain chain = RunChain(keyframes, window, seed);
      ms.push_back(1000 * chain.seconds / (keyframes - 2));
      centres.push_back(chain.centre_pct);
      rms.push_back(chain.rms_px);
    }
    constexpr int kInUse = 14;
    panel.points.push_back(
        {"keyframes moved", std::to_string(window), Spread::Of(ms), Spread::Of(centres), window == kInUse});
    pixels.points.push_back(
        {"keyframes moved", std::to_string(window), Spread::Of(ms), Spread::Of(rms), window == kInUse});
  }
  chart.panels.push_back(panel);
  chart.panels.push_back(pixels);
}

}  // namespace

Chart BundleChart(const ChartEffort& effort) {
  Chart chart;
  chart.title = "Bundle adjustment: solver, views and window";
  chart.about =
      "Drawn scenes, 0.5 px of noise and 2 % of outliers, sigma 1 px. Above: views on a cap that each see a "
      "fifth of 1,500 points, begun 1 % and 0.6 degrees off; ringed is the solver in use at that size. "
      "Below: "
      "drift when only the newest keyframes are moved, the twenty before them held. Three seeds, none of "
      "them "
      "used for choosing; bars: lowest to highest.";
  AddSolvers(chart, effort);
  AddWindows(chart, effort);
  return chart;
}

}  // namespace ulf::test
