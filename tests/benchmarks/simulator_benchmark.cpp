// Milliseconds to make one frame of the simulated camera, by format, size and length of the motion blur.
#include <benchmark/benchmark.h>

#include "acquisition/simulator/simulated_camera.h"
#include "tests/measure/figures.h"
#include "tests/support/floors.h"

namespace ulf {
namespace {

// The moment in the first minute at which an exposure of 5 ms smears by about `blur_px`.
double MomentWithBlur(const SimulatedCamera& camera, double blur_px) {
  double best_s = 0, best = 1e9;
  for (double t = 0; t < 60; t += 0.02) {
    const double off = std::abs(camera.BlurPx(t, 0.005) - blur_px);
    if (off < best) {
      best = off;
      best_s = t;
    }
  }
  return best_s;
}

void CaptureFrame(benchmark::State& state, SensorFormat format, int width, double blur_px) {
  SimulationOptions options;
  options.width = width;
  options.height = width * 3 / 4;
  const SimulatedCamera camera(options);
  const double open_s = MomentWithBlur(camera, blur_px);
  std::uint64_t id = 0;
  for ([[maybe_unused]] auto _ : state)
    benchmark::DoNotOptimize(camera.Capture({.open_s = open_s, .format = format, .id = id++}));
  state.counters["blur_px"] = camera.BlurPx(open_s, 0.005);
}

void BuildScene(benchmark::State& state) {
  for ([[maybe_unused]] auto _ : state) benchmark::DoNotOptimize(Scene::Named("studio"));
}

BENCHMARK(BuildScene)->Unit(benchmark::kMillisecond)->Iterations(1);
BENCHMARK_CAPTURE(CaptureFrame, mono8_640_still, SensorFormat::kMono8, 640, 0)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(CaptureFrame, bayer8_640_still, SensorFormat::kBayerRg8, 640, 0)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(CaptureFrame, rgb8_640_still, SensorFormat::kRgb8, 640, 0)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(CaptureFrame, rgb8_640_blur2, SensorFormat::kRgb8, 640, 2)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(CaptureFrame, rgb8_640_blur4, SensorFormat::kRgb8, 640, 4)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(CaptureFrame, rgb8_1280_still, SensorFormat::kRgb8, 1280, 0)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace ulf

int main(int argc, char** argv) { return ulf::RunBenchmarks(argc, argv); }
