// The operator display at 1280x720 with software OpenGL that has one thread: what a display frame costs in
// CPU time of all the process's threads, with a new live picture in each. The targets are the display's own:
// 30 frames in the second of one core that it has beside tracking. `of_a_core` says how much of that core 30
// frames a second take. BM_LiveBesideTracking has both at once, each on a core of its own, by the clock: what
// else the machine does spoils it.
#include <benchmark/benchmark.h>

#include <sched.h>

#include <atomic>
#include <cstdlib>
#include <functional>
#include <thread>

#include "acquisition/simulator/simulated_camera.h"
#include "coverage/operator/operator_display.h"
#include "tests/measure/figures.h"
#include "tests/support/floors.h"
#include "tests/support/staged_capture.h"
#include "tracking/sources/poses_spec.h"

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
        RecordedFrame view = *state->newest_view;
        view.frame.image = state->live;
        state->newest_view = std::make_shared<RecordedFrame>(view);
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
  for ([[maybe_unused]] auto _ : state) {
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

// Threads that this one begins stay there, too.
void StayOnCore(int core) {
  cpu_set_t only;
  CPU_ZERO(&only);
  CPU_SET(core, &only);
  sched_setaffinity(0, sizeof only, &only);
}

// A camera's 30 frames a second of 1280x720, tracked and mapped (on the same core), until `over`.
std::uint64_t TrackInTime(const std::vector<Frame>& frames, const CameraModel& camera,
                          const std::atomic<bool>& over) {
  using Clock = std::chrono::steady_clock;
  constexpr double kFps = 30;
  const auto source = MakeTrackerSource(camera, {});
  const auto start = Clock::now();
  std::uint64_t tracked = 0;
  for (std::uint64_t slot = 0; !over; ++slot) {
    const auto due = start + std::chrono::duration_cast<Clock::duration>(
                                 std::chrono::duration<double>(static_cast<double>(slot) / kFps));
    if (Clock::now() > due + std::chrono::milliseconds(40)) continue;  // the camera has dropped it
    std::this_thread::sleep_until(due);
    const std::size_t there_and_back = slot % (2 * frames.size() - 2);
    Frame frame = frames[std::min(there_and_back, 2 * frames.size() - 2 - there_and_back)];
    frame.device_time_s = static_cast<double>(slot) / kFps;
    tracked += source->Step(frame).state == TrackState::kTracking;
  }
  return tracked;
}

// With a display beside it when there is one to step.
double TrackedFps(const std::vector<Frame>& frames, const CameraModel& camera, int core,
                  const std::function<void()>& meanwhile) {
  std::atomic<bool> over = false;
  std::uint64_t tracked = 0;
  const auto start = std::chrono::steady_clock::now();
  std::thread tracking([&] {
    StayOnCore(core);
    tracked = TrackInTime(frames, camera, over);
  });
  meanwhile();
  over = true;
  tracking.join();
  return static_cast<double>(tracked) /
         std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

void BM_LiveBesideTracking(benchmark::State& state) {
  cpu_set_t before;
  sched_getaffinity(0, sizeof before, &before);
  std::vector<int> cores;
  for (int core = 0; core < CPU_SETSIZE; ++core)
    if (CPU_ISSET(core, &before)) cores.push_back(core);
  if (cores.size() < 2) return state.SkipWithError("wants two cores");
  const Stage& stage = TheStage();
  const SimulatedCamera simulated(
      SimulationOptions::FromUri(DeviceUri::Parse("sim:studio?width=1280&height=720&fps=30&seed=3")));
  std::vector<Frame> frames;
  for (std::uint64_t i = 0; i < 90; ++i) frames.push_back(simulated.Capture(i));
  constexpr double kSeconds = 15;
  for ([[maybe_unused]] auto _ : state) {
    const double alone_fps = TrackedFps(frames, simulated.camera(), cores[0], [&] {
      std::this_thread::sleep_for(std::chrono::duration<double>(kSeconds));
    });
    std::uint64_t shown = 0;
    double seconds = 0;
    const double beside_fps = TrackedFps(frames, simulated.camera(), cores[0], [&] {
      StayOnCore(cores[1]);
      OffscreenSurface surface({1280, 720});
      CaptureFeed feed;
      CaptureRequests requests;
      OperatorDisplay display(surface, feed, requests);
      const auto start = std::chrono::steady_clock::now();
      for (; seconds < kSeconds; ++shown) {
        feed.Publish(std::make_shared<CaptureState>(*stage.live[shown % stage.live.size()]));
        display.Step();
        seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
      }
    });
    state.counters["display_fps"] = static_cast<double>(shown) / seconds;
    state.counters["tracked_alone_fps"] = alone_fps;
    state.counters["tracked_of_alone"] = beside_fps / alone_fps;
  }
  sched_setaffinity(0, sizeof before, &before);
}
BENCHMARK(BM_LiveBesideTracking)->Iterations(1)->Unit(benchmark::kSecond);
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
      {{"BM_Live/", "frames_a_cpu_second", 30,
        "display frames in a CPU second without tracking's share, live view with the painted sphere"},
       {"BM_LiveBesideTracking", "display_fps", 30,
        "display frames a second by the clock, beside tracking of 30 frames a second on the other core"},
       {"BM_LiveBesideTracking", "tracked_of_alone", 0.95,
        "frames tracked beside the display, of those tracked without one"},
       {"BM_SubjectToolWithAperture", "frames_a_cpu_second", 10,
        "display frames in a CPU second without tracking's share, augmented aperture"},
       {"BM_Review", "frames_a_cpu_second", 10,
        "display frames in a CPU second without tracking's share, review"}});
}
