// The operator display at 1280x720 with software OpenGL that has one thread: what a display frame costs in
// CPU time of all the process's threads, with a new live picture in each. The targets are the display's own:
// 30 frames in the second of one core that it has beside tracking, which takes its own time on another
// (tracking_benchmark). `of_a_core` says how much of that core 30 frames a second take; what is left of it is
// what tracking may have where there is only one.
#include <benchmark/benchmark.h>

#include <cstdlib>

#include "coverage/operator/operator_display.h"
#include "tests/benchmarks/figures.h"
#include "tests/support/staged_capture.h"

namespace ulf {
namespace {

// Two live pictures by turns over a map of 193 views, and pictures of two dozen of them.
struct Stage {
  test::StagedCapture capture{{.width = 1280, .height = 720}};
  std::vector<std::shared_ptr<CaptureState>> live, recorded;

  Stage() {
    const test::StagedCapture pictures({.width = 1280, .height = 720, .rendered = true});
    capture.Record(capture.CameraAt(0, 0));
    for (const double elevation : {-9.0, -3.0, 3.0, 9.0})
      for (const double azimuth : {-12.0, -8.0, -4.0, 0.0, 4.0, 8.0}) {
        auto state = capture.Record(capture.CameraAt(azimuth, elevation));
        state->live = pictures.At(*state->cam_from_world)->live;
        RecordedView view = *state->newest_view;
        view.frame.image = state->live;
        state->newest_view = std::make_shared<RecordedView>(view);
        recorded.push_back(state);
      }
    for (int row = 0; row < 12; ++row)
      for (int column = 0; column < 14; ++column)
        capture.Record(capture.CameraAt(-28 + 4.1 * column, -19 + 3.2 * row));
    for (const double azimuth : {4.0, 4.3}) {
      auto state = capture.At(capture.CameraAt(azimuth, 2));
      state->live = pictures.At(*state->cam_from_world)->live;
      const Eigen::Vector3d target = capture.CameraAt(20, 8).OriginInSource();
      state->guidance.toward = (target - capture.subject().center_in_world).normalized();
      state->guidance.disc_radius = 0.04;
      live.push_back(state);
    }
  }
};

const Stage& TheStage() {
  static const Stage stage;
  return stage;
}

void ShowFrames(benchmark::State& state, const std::string& keys) {
  const Stage& stage = TheStage();
  OffscreenSurface surface({1280, 720});
  CaptureFeed feed;
  CaptureRequests requests;
  OperatorDisplay display(surface, feed, requests);
  for (const auto& recorded : stage.recorded) {
    feed.Publish(recorded);
    display.Step();
  }
  for (const char key : keys) surface.Push(Typed{static_cast<char32_t>(key)});
  std::size_t frame = 0;
  double start_s = 0;
  constexpr std::size_t kWarmUp = 4;  // pictures are uploaded
  for (auto _ : state) {
    if (frame == kWarmUp) start_s = CpuSeconds();
    feed.Publish(std::make_shared<CaptureState>(*stage.live[frame % stage.live.size()]));
    display.Step();
    ++frame;
  }
  if (frame <= kWarmUp) return;
  const double ms = 1000 * (CpuSeconds() - start_s) / static_cast<double>(frame - kWarmUp);
  state.counters["cpu_ms_a_frame"] = ms;
  state.counters["frames_a_cpu_second"] = 1000 / ms;
  state.counters["of_a_core"] = 30 * ms / 1000;
}

void BM_Live(benchmark::State& state) { ShowFrames(state, ""); }
void BM_Keys(benchmark::State& state) { ShowFrames(state, "?"); }
void BM_SubjectToolWithAperture(benchmark::State& state) { ShowFrames(state, "s"); }
void BM_Review(benchmark::State& state) { ShowFrames(state, "r"); }
BENCHMARK(BM_Live)->Iterations(100)->Unit(benchmark::kMillisecond);
BENCHMARK(BM_Keys)->Iterations(60)->Unit(benchmark::kMillisecond);
BENCHMARK(BM_SubjectToolWithAperture)->Iterations(60)->Unit(benchmark::kMillisecond);
BENCHMARK(BM_Review)->Iterations(60)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace ulf

int main(int argc, char** argv) {
  setenv("LIBGL_ALWAYS_SOFTWARE", "1", 1);
  setenv("LP_NUM_THREADS", "1", 1);
  cv::setNumThreads(1);
  return ulf::RunBenchmarks(
      argc, argv,
      {{"BM_Live", "frames_a_cpu_second", 30,
        "display frames in a CPU second without tracking's share, live view with the painted sphere"},
       {"BM_SubjectToolWithAperture", "frames_a_cpu_second", 10,
        "display frames in a CPU second without tracking's share, augmented aperture"},
       {"BM_Review", "frames_a_cpu_second", 10,
        "display frames in a CPU second without tracking's share, review"}});
}
