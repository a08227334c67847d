// Geometry while shooting: what it costs the tracker, and how soon after the last frame the mesh is there.
//
// What it costs: both runs track the same frames at a camera's pace, in turn, without and with depth maps
// being made beside them all the time. What is compared is the median of the frames' times.
//
// How soon: 200 views along a hand's way over the cap come five a second, then the geometry is finished.
#include <benchmark/benchmark.h>

#include <chrono>
#include <thread>
#include <vector>

#include "acquisition/simulator/simulated_camera.h"
#include "coverage/session/record/live_geometry.h"
#include "tests/measure/figures.h"
#include "tests/support/floors.h"
#include "tracking/sources/poses_spec.h"

namespace ulf {
namespace {

constexpr double kFps = 30;
constexpr std::size_t kFrames = 150, kFramesOfAView = 5;

struct Shoot {
  SimulatedCamera camera;
  std::vector<Frame> frames;
};

const Shoot& TheShoot() {
  static const Shoot shoot = [] {
    Shoot made{SimulatedCamera(SimulationOptions::FromUri(DeviceUri::Parse(
                   "sim:studio?width=640&height=480&fps=30&seed=3&look_away=0&speed_deg_s=8"))),
               {}};
    for (std::uint64_t i = 0; i < kFrames; ++i) made.frames.push_back(made.camera.Capture(i));
    return made;
  }();
  return shoot;
}

// Milliseconds of each frame.
std::vector<double> TrackAtPace(LiveGeometry* geometry) {
  const Shoot& shoot = TheShoot();
  const auto source = MakeTrackerSource(shoot.camera.camera(), {});
  std::vector<double> ms;
  const auto start = Clock::now();
  int id = 0;
  // There and back: nothing jumps.
  for (std::size_t i = 0; i < 2 * kFrames; ++i) {
    std::this_thread::sleep_until(start + std::chrono::duration_cast<Clock::duration>(
                                              std::chrono::duration<double>(static_cast<double>(i) / kFps)));
    Frame frame = shoot.frames[i < kFrames ? i : 2 * kFrames - 1 - i];
    frame.device_time_s = static_cast<double>(i) / kFps;
    const auto begun = Clock::now();
    source->Step(frame);
    ms.push_back(1e3 * SecondsSince(begun));
    if (geometry && i % kFramesOfAView == 0)
      geometry->AddView(
          id++, [image = frame.image] { return Srgb8(image); }, shoot.camera.camera(),
          *frame.known_cam_from_world);
  }
  return ms;
}

void BM_TrackerBesideGeometry(benchmark::State& state) {
  TheShoot();
  constexpr int kTurns = 3;
  for ([[maybe_unused]] auto _ : state) {
    std::vector<double> alone, beside;
    double processor_s = 0, seconds = 0;
    int maps = 0;
    for (int turn = 0; turn < kTurns; ++turn) {
      for (const double ms : TrackAtPace(nullptr)) alone.push_back(ms);
      LiveGeometry::Options options;
      options.growing.least_apart = 0;  // there is always another map to be made
      options.growing.depth_maps = 100000;
      LiveGeometry geometry(options);
      geometry.SetSubject(TheShoot().camera.scene().subject());
      const auto start = Clock::now();
      for (const double ms : TrackAtPace(&geometry)) beside.push_back(ms);
      seconds += SecondsSince(start);
      processor_s += geometry.State().processor_s;
      maps += geometry.State().maps;
    }
    state.counters["ms_alone"] = Median(alone);
    state.counters["of_alone"] = Median(beside) / Median(alone);
    state.counters["slow_frames_of_alone"] = Quantile(beside, 0.95) / Quantile(alone, 0.95);
    state.counters["processor_share"] = processor_s / seconds;
    state.counters["maps"] = maps;
  }
}
BENCHMARK(BM_TrackerBesideGeometry)->Iterations(1)->Unit(benchmark::kSecond);

void BM_MeshAfterTheLastFrame(benchmark::State& state) {
  const SimulatedCamera& camera = TheShoot().camera;
  const Hand& hand = dynamic_cast<const Hand&>(camera.hand());
  constexpr int kViews = 200;
  constexpr std::chrono::milliseconds kBetweenViews(200);
  for ([[maybe_unused]] auto _ : state) {
    LiveGeometry geometry({});
    geometry.SetSubject(camera.scene().subject());
    auto due = Clock::now();
    for (int i = 0; i < kViews; ++i) {
      const Rigid3 pose = hand.CamFromWorld(hand.FirstPassEndS() * (i + 0.5) / kViews);
      geometry.AddView(
          i, [picture = camera.CleanSrgb(pose)] { return picture; }, camera.camera(), pose,
          LiveGeometry::Picture::kIsHeld);
      std::this_thread::sleep_until(due += kBetweenViews);
    }
    const LiveGeometryState before = geometry.State();
    const FinishedGeometry finished = geometry.Finish();
    state.counters["seconds"] = finished.seconds;
    state.counters["maps"] = finished.maps;
    state.counters["maps_before"] = before.maps;
    state.counters["missing_maps"] = finished.missing_maps;
    state.counters["views_left_out"] = static_cast<double>(finished.views_left_out.size());
    state.counters["triangles"] =
        finished.mesh ? static_cast<double>(finished.mesh->mesh->triangles.size()) : 0;
  }
}
BENCHMARK(BM_MeshAfterTheLastFrame)->Iterations(1)->Unit(benchmark::kSecond);

}  // namespace
}  // namespace ulf

int main(int argc, char** argv) {
  return ulf::RunBenchmarks(argc, argv,
                            {{"BM_TrackerBesideGeometry", "of_alone", 0,
                              "time of a tracked frame beside geometry, of that without", 1.03},
                             {"BM_TrackerBesideGeometry", "processor_share", 0,
                              "processor time of geometry, of one processor", 0.45},
                             {"BM_MeshAfterTheLastFrame", "seconds", 0,
                              "from the last frame to the mesh of 200 views at 640x480, s", 10}});
}
