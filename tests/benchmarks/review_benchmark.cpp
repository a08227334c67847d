// The marker as a mouse at 640x480 on one core: marker found, pose, nearest view drawn; beside bare
// cv::aruco::detectMarkers on the same pictures, and as a share of the 33 ms that a frame has.
#include <benchmark/benchmark.h>

#include <opencv2/aruco.hpp>
#include <opencv2/core/utility.hpp>

#include "acquisition/simulator/simulated_board.h"
#include "acquisition/simulator/simulated_camera.h"
#include "core/base/host_time.h"
#include "coverage/operator/marker_mouse.h"
#include "render/quality/nearest_view.h"
#include "tests/measure/figures.h"
#include "tests/render/scenes/held_photograph.h"
#include "tests/support/floors.h"
#include "tracking/sources/marker_locator.h"

namespace ulf {
namespace {

constexpr const char* kBoard = "aruco:3x4:45:9:DICT_4X4_50";
constexpr int kFrames = 45;

// A marker board carried before the camera; the second half of each place is on the way to the next.
struct Held {
  CameraModel camera;
  std::vector<cv::Mat> frames;
};
const Held& HeldBoard(const std::string& board) {
  static std::map<std::string, Held> made;
  Held& held = made[board];
  if (!held.frames.empty()) return held;
  BoardSceneOptions options;
  options.board = Board::Parse(board);
  options.camera = SimulatedLens("barrel", 640, 480);
  const BoardScene scene(options);
  held.camera = options.camera;
  for (int i = 0; i < kFrames; ++i)
    held.frames.push_back(
        GrayForTracking({scene.Render(scene.HeldAt(static_cast<std::uint64_t>(i / 15), (i % 15) / 15.0),
                                      static_cast<std::uint64_t>(i)),
                         Transfer::kLinear}));
  return held;
}

// A board in a cluttered room, as a hand-held camera sees it.
const Held& Cluttered() {
  static Held held;
  if (!held.frames.empty()) return held;
  SimulationOptions options;
  options.scene = "easel";
  options.looks_away = false;
  options.fps = 30;
  const SimulatedCamera camera(options);
  held.camera = camera.camera();
  for (int i = 0; i < kFrames; ++i)
    held.frames.push_back(GrayForTracking(camera.Capture(static_cast<std::uint64_t>(i)).image));
  return held;
}

const Held& Pictures(int which) {
  return which == 0 ? HeldBoard(kBoard) : which == 1 ? HeldBoard("aruco:1x1:80:10:DICT_4X4_50") : Cluttered();
}
const char* Label(int which) {
  return which == 0 ? "board" : which == 1 ? "single marker" : "board in clutter";
}
MarkerSpec Spec(int which) { return MarkerSpec::Parse(which == 1 ? "marker:80:DICT_4X4_50:0" : kBoard); }

const RenderScene& LightFieldOfStudio() {
  static const RenderScene scene = [] {
    SimulationOptions options;
    options.looks_away = false;
    const SimulatedCamera camera(options);
    RenderScene made;
    made.subject = camera.scene().subject();
    made.up_in_world = Eigen::Vector3d::UnitZ();
    for (int i = 0; i < 40; ++i) {
      SceneView view;
      view.id = i + 1;
      view.camera = camera.camera();
      view.cam_from_world = camera.hand().CamFromWorld(0.5 * i);
      view.center_in_world = view.cam_from_world.OriginInSource();
      view.photograph = test::HoldPhotograph(MakePyramid(camera.CleanSrgb(view.cam_from_world)));
      made.views.push_back(view);
    }
    return made;
  }();
  return scene;
}

void BM_BareAruco(benchmark::State& state) {
  cv::setNumThreads(1);
  const int which = static_cast<int>(state.range(0));
  const auto dictionary = cv::aruco::getPredefinedDictionary(cv::aruco::DICT_4X4_50);
  const auto parameters = cv::aruco::DetectorParameters::create();
  parameters->cornerRefinementMethod = cv::aruco::CORNER_REFINE_SUBPIX;
  std::vector<std::vector<cv::Point2f>> corners;
  std::vector<int> ids;
  std::size_t frame = 0;
  const Held& held = Pictures(which);
  for ([[maybe_unused]] auto _ : state)
    cv::aruco::detectMarkers(held.frames[frame++ % kFrames], dictionary, corners, ids, parameters);
  state.SetLabel(Label(which));
}
BENCHMARK(BM_BareAruco)->DenseRange(0, 2)->Unit(benchmark::kMillisecond);

void BM_FindMarkerAndPose(benchmark::State& state) {
  cv::setNumThreads(1);
  const int which = static_cast<int>(state.range(0));
  const Held& held = Pictures(which);
  MarkerLocator locator(held.camera, Spec(which));
  std::size_t frame = 0;
  double posed = 0;
  for ([[maybe_unused]] auto _ : state) {
    posed += locator.Locate(held.frames[frame % kFrames], static_cast<double>(frame) / 30).has_value();
    ++frame;
  }
  state.counters["posed"] = posed / static_cast<double>(frame);
  state.SetLabel(Label(which));
}
BENCHMARK(BM_FindMarkerAndPose)->DenseRange(0, 2)->Unit(benchmark::kMillisecond);

void BM_ReviewFrame(benchmark::State& state) {
  cv::setNumThreads(1);
  const int which = static_cast<int>(state.range(0));
  const Held& held = Pictures(which);
  const RenderScene& scene = LightFieldOfStudio();
  const NearestViewRenderer renderer(scene);
  const CameraModel camera = CameraModel::Pinhole(640, 480, 560);
  const MarkerSpec spec = Spec(which);
  MarkerLocator locator(held.camera, spec);
  MarkerMouse mouse(scene, spec.Middle());
  cv::Mat drawn;
  Rigid3 pose{Eigen::Quaterniond::Identity(), {0, 0, 0.5}};
  std::size_t frame = 0;
  const double start_s = ThreadCpuSeconds();
  for ([[maybe_unused]] auto _ : state) {
    const auto found = locator.Locate(held.frames[frame % kFrames], static_cast<double>(frame) / 30);
    if (found) pose = found->cam_from_world;
    renderer.Draw(camera, mouse.CamFromWorld(pose), drawn);
    ++frame;
  }
  state.counters["frames_a_second"] = static_cast<double>(frame) / (ThreadCpuSeconds() - start_s);
  state.SetLabel(Label(which));
}
BENCHMARK(BM_ReviewFrame)->DenseRange(0, 2)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace ulf

int main(int argc, char** argv) {
  return ulf::RunBenchmarks(
      argc, argv, {{"BM_ReviewFrame", "frames_a_second", 30, "pictures shown in a second of one core"}});
}
