// What a coverage decision costs: one bound, one frame against the recorded views, one view painted, one cap
// measured. On one core; what is asked of a decision and of a new view is judged.
#include <benchmark/benchmark.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <memory>
#include <random>

#include "coverage/bound/coverage_map.h"
#include "coverage/bound/criterion.h"
#include "tests/measure/figures.h"
#include "tests/support/floors.h"

namespace ulf {
namespace {

using Eigen::Vector3d;

const Subject kSubject{Vector3d::Zero(), 0.15};

CriterionView ViewAt(double azimuth, double elevation, double distance) {
  CriterionView camera;
  camera.fx = camera.fy = 600;
  camera.width = 640, camera.height = 480, camera.cx = 320, camera.cy = 240;
  const CapFrame frame(Vector3d::UnitX(), Vector3d::UnitZ());
  return camera.AimedAt(Vector3d::Zero(), distance * frame.Direction(azimuth, elevation), Vector3d::UnitZ());
}

const Cap kUsualCap{1.04, 0.7};

constexpr unsigned kRecordedSeed = 1, kLiveSeed = 2;  // no live frame is a recorded view

// As a capture leaves them: over a 60x40 degree cap, distances within a few percent, aim off by some degrees.
std::vector<CriterionView> Capture(int count, const Cap& cap = kUsualCap, unsigned seed = kRecordedSeed,
                                   double mean_distance = 1) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> azimuth(-cap.width / 2, cap.width / 2), turn(-0.1, 0.1),
      height(-std::sin(cap.height / 2), std::sin(cap.height / 2));
  std::normal_distribution<double> distance(mean_distance, 0.04 * mean_distance);
  std::vector<CriterionView> views;
  for (int i = 0; i < count; ++i) {
    views.push_back(ViewAt(azimuth(random), std::asin(height(random)), distance(random)));
    views.back().cam_from_world =
        Eigen::AngleAxisd(turn(random), Vector3d::UnitY()).toRotationMatrix() * views.back().cam_from_world;
  }
  return views;
}

void BoundNearTheShell(benchmark::State& state) {
  const CriterionView recorded = ViewAt(0, 0, 1), candidate = ViewAt(0.02, 0.01, 1.05);
  for ([[maybe_unused]] auto _ : state) benchmark::DoNotOptimize(BoundPx(recorded, candidate, kSubject));
}
BENCHMARK(BoundNearTheShell);

void BoundFarFromTheShell(benchmark::State& state) {
  const CriterionView recorded = ViewAt(0, 0, 1), candidate = ViewAt(0.02, 0.01, 1.6);
  for ([[maybe_unused]] auto _ : state) benchmark::DoNotOptimize(BoundPx(recorded, candidate, kSubject));
}
BENCHMARK(BoundFarFromTheShell);

// What is timed by itself, without what each iteration needs before it.
struct OwnTimes {
  double seconds = 0, slowest_s = 0, count = 0;
  void Add(benchmark::State& state, double one_s) {
    state.SetIterationTime(one_s);
    seconds += one_s;
    slowest_s = std::max(slowest_s, one_s);
    ++count;
  }
  void Tell(benchmark::State& state) const {
    state.counters["a_second"] = count / seconds;
    state.counters["slowest_ms"] = 1e3 * slowest_s;
  }
};

// One live frame against all recorded views: the exact smallest bound.
void Decision(benchmark::State& state) {
  SubjectViews recorded(kSubject);
  for (const CriterionView& view : Capture(static_cast<int>(state.range(0)))) recorded.Add(view);
  // Live cameras at so many percent of the recorded distance; 0: as recorded, but beside the cap.
  const double percent = static_cast<double>(state.range(1));
  const Cap beside{3, 2};
  const std::vector<CriterionView> candidates =
      percent > 0 ? Capture(257, kUsualCap, kLiveSeed, percent / 100) : Capture(257, beside, kLiveSeed);
  std::size_t i = 0;
  OwnTimes times;
  for ([[maybe_unused]] auto _ : state) {
    const auto start = Clock::now();
    benchmark::DoNotOptimize(recorded.Best(candidates[i++ % candidates.size()]));
    times.Add(state, SecondsSince(start));
  }
  times.Tell(state);
}
BENCHMARK(Decision)
    ->ArgsProduct({{100, 1000, 10'000}, {100, 50, 160, 0}})
    ->UseManualTime()
    ->Unit(benchmark::kMicrosecond);

void PaintOneView(benchmark::State& state) {
  const CoverageMap before(kSubject, {.cap = Cap::ParseDegrees("60x40"), .threshold_px = 7},
                           Capture(static_cast<int>(state.range(0))));
  const std::vector<CriterionView> more = Capture(257, kUsualCap, kLiveSeed);
  std::size_t i = 0;
  OwnTimes times;
  for ([[maybe_unused]] auto _ : state) {
    CoverageMap map = before;
    const auto start = Clock::now();
    map.Add(more[i++ % more.size()]);
    times.Add(state, SecondsSince(start));
  }
  times.Tell(state);
}
BENCHMARK(PaintOneView)
    ->Arg(700)
    ->Arg(1000)
    ->Arg(10'000)
    ->UseManualTime()
    ->Unit(benchmark::kMicrosecond)
    ->Iterations(200);

// As a capture paints: into a copy of the map, which nobody has seen yet.
void PaintOneViewOfAMapInUse(benchmark::State& state, const Cap& cap) {
  const auto in_use =
      std::make_shared<const CoverageMap>(kSubject, CoverageMapOptions{.cap = cap, .threshold_px = 7},
                                          Capture(static_cast<int>(state.range(0)), cap));
  const std::vector<CriterionView> more = Capture(257, cap, kLiveSeed);
  std::size_t i = 0;
  double seconds = 0, copying_s = 0;
  std::shared_ptr<const CoverageMap> looked_at;
  for ([[maybe_unused]] auto _ : state) {
    const auto start = Clock::now();
    auto map = std::make_shared<CoverageMap>(*in_use);
    copying_s += SecondsSince(start);
    map->Add(more[i++ % more.size()]);
    const double one_s = SecondsSince(start);
    state.SetIterationTime(one_s);
    seconds += one_s;
    looked_at = std::move(map);  // the one before goes
  }
  std::size_t cells = 0;
  in_use->ForEachCell([&](const CoverageMap::CellView&) { ++cells; });
  state.counters["cells"] = static_cast<double>(cells);
  state.counters["a_second"] = static_cast<double>(i) / seconds;
  state.counters["copy_us"] = 1e6 * copying_s / static_cast<double>(i);
}
void PaintInUseCap(benchmark::State& state) { PaintOneViewOfAMapInUse(state, Cap::ParseDegrees("60x40")); }
void PaintInUseSphere(benchmark::State& state) { PaintOneViewOfAMapInUse(state, Cap::WholeSphere()); }
BENCHMARK(PaintInUseCap)
    ->Arg(100)
    ->Arg(1000)
    ->Arg(10'000)
    ->UseManualTime()
    ->Unit(benchmark::kMicrosecond)
    ->Iterations(200);
BENCHMARK(PaintInUseSphere)
    ->Arg(100)
    ->Arg(1000)
    ->Arg(10'000)
    ->UseManualTime()
    ->Unit(benchmark::kMicrosecond)
    ->Iterations(200);

void PaintAnew(benchmark::State& state) {
  const std::vector<CriterionView> views = Capture(static_cast<int>(state.range(0)));
  for ([[maybe_unused]] auto _ : state)
    benchmark::DoNotOptimize(
        CoverageMap(kSubject, {.cap = Cap::ParseDegrees("60x40"), .threshold_px = 7}, views).CoveredShare());
}
BENCHMARK(PaintAnew)->Arg(700)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace ulf

int main(int argc, char** argv) {
  return ulf::RunBenchmarks(
      argc, argv,
      {{"Decision/1000/100/", "a_second", 1 / 0.3e-3, "decisions a second, 1,000 views (0.3 ms)"},
       {"Decision/1000/50/", "a_second", 1 / 0.3e-3, "the same from half the distance"},
       {"Decision/1000/160/", "a_second", 1 / 0.3e-3, "the same from 1.6 of the distance"},
       {"Decision/1000/0/", "a_second", 1 / 0.3e-3, "the same also beside the cap"},
       {"Decision/10000/100/", "a_second", 1 / 3e-3, "decisions a second, 10,000 views (3 ms)"},
       {"Decision/10000/50/", "a_second", 1 / 3e-3, "the same from half the distance"},
       {"Decision/10000/160/", "a_second", 1 / 3e-3, "the same from 1.6 of the distance"},
       {"Decision/10000/0/", "a_second", 1 / 3e-3, "the same also beside the cap"},
       {"PaintOneView/1000/", "a_second", 1 / 1e-3, "views painted a second, 1,000 views (1 ms)"},
       {"PaintOneView/10000/", "a_second", 1 / 1e-3, "views painted a second, 10,000 views (1 ms)"},
       {"PaintInUseCap/1000/", "a_second", 1 / 1e-3,
        "views painted a second while somebody looks, 1,000 views (1 ms)"},
       {"PaintInUseCap/10000/", "a_second", 1 / 1e-3,
        "views painted a second while somebody looks, 10,000 views (1 ms)"},
       {"PaintInUseSphere/10000/", "a_second", 1 / 1e-3,
        "views painted a second while somebody looks, whole sphere, 10,000 views (1 ms)"}});
}
