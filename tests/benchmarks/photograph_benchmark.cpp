// What photographs cost before they are drawn: decoding, pyramids, their files; the first picture of 800
// views; pictures from less graphics memory than they need. Photographs of 1 MP of the simulated studio, 16
// of them under 800 names, in a folder of this program's own.
#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <cmath>
#include <cstdint>
#include <opencv2/imgcodecs.hpp>

#include "acquisition/simulator/simulated_camera.h"
#include "core/light_field/folder/light_field_io.h"
#include "render/gl/gl_renderer.h"
#include "render/output/camera_path.h"
#include "render/photographs/pyramid_file.h"
#include "tests/measure/figures.h"
#include "tests/render/scenes/held_photograph.h"
#include "tests/support/floors.h"
#include "tests/support/test_paths.h"

namespace ulf {
namespace {

namespace fs = std::filesystem;
constexpr int kViews = 800, kDifferent = 16;

const SimulatedCamera& Studio() {
  static const SimulatedCamera camera = [] {
    SimulationOptions options;
    options.width = 1152;
    options.height = 864;
    options.looks_away = false;
    return SimulatedCamera(options);
  }();
  return camera;
}

// Of a camera: with noise, which is most of what a file holds.
cv::Mat Photograph1Mp() {
  static const cv::Mat photograph = [] {
    cv::Mat noise(Studio().camera().height, Studio().camera().width, CV_8SC3), noisy;
    cv::RNG(3).fill(noise, cv::RNG::NORMAL, 0, 2);
    cv::add(Studio().CleanSrgb(Studio().hand().CamFromWorld(1)), noise, noisy, cv::noArray(), CV_8U);
    return noisy;
  }();
  return photograph;
}

const fs::path& ManyViews() {
  static const test::ScratchFolder scratch;
  static const fs::path dir = [] {
    LightField light_field;
    light_field.root = scratch / "lf";
    light_field.cameras = {Studio().camera()};
    light_field.subject = Studio().scene().subject();
    light_field.up_in_world = Eigen::Vector3d::UnitZ();
    fs::create_directories(light_field.root / "images");
    for (int i = 0; i < kViews; ++i) {
      View view;
      view.id = i + 1;
      view.image_path = fmt::format("images/{:06}.png", view.id);
      view.cam_from_world = Studio().hand().CamFromWorld(0.05 * i);
      if (i < kDifferent)
        cv::imwrite((light_field.root / view.image_path).string(), Photograph1Mp());
      else
        fs::create_hard_link(
            light_field.root / light_field.views[static_cast<std::size_t>(i % kDifferent)].image_path,
            light_field.root / view.image_path);
      light_field.views.push_back(view);
    }
    WriteLightField(light_field);
    return light_field.root;
  }();
  return dir;
}

void Decode(benchmark::State& state, const char* extension) {
  std::vector<unsigned char> file;
  cv::imencode(extension, Photograph1Mp(), file);
  for ([[maybe_unused]] auto _ : state) benchmark::DoNotOptimize(cv::imdecode(file, cv::IMREAD_UNCHANGED));
  state.counters["MB"] = 1e-6 * static_cast<double>(file.size());
}

void Pyramid(benchmark::State& state) {
  for ([[maybe_unused]] auto _ : state) benchmark::DoNotOptimize(MakePyramid(Photograph1Mp()));
}

void WriteFile(benchmark::State& state) {
  const test::ScratchFolder scratch;
  const ViewPyramid pyramid = MakePyramid(Photograph1Mp());
  for ([[maybe_unused]] auto _ : state) WritePyramidFile(scratch / "x.pyramid", 1, pyramid);
  state.counters["MB"] = 1e-6 * static_cast<double>(fs::file_size(scratch / "x.pyramid"));
}

void ReadFile(benchmark::State& state) {
  const test::ScratchFolder scratch;
  const ViewPyramid pyramid = MakePyramid(Photograph1Mp());
  WritePyramidFile(scratch / "x.pyramid", 1, pyramid);
  const auto photograph = test::HoldPhotograph(pyramid);
  for ([[maybe_unused]] auto _ : state)
    benchmark::DoNotOptimize(
        ReadPyramidFile(scratch / "x.pyramid", 1, *photograph, static_cast<int>(state.range(0))));
}

// What a mesh of 100,000 triangles hides from one view.
void ShadowMapOfOneView(benchmark::State& state) {
  constexpr int kSide = 224;
  TriangleMesh mesh;
  for (int y = 0; y <= kSide; ++y)
    for (int x = 0; x <= kSide; ++x)
      mesh.vertices.emplace_back(2.0f * static_cast<float>(x) / kSide - 1,
                                 2.0f * static_cast<float>(y) / kSide - 1,
                                 0.1f * std::sin(0.3f * static_cast<float>(x + y)));
  for (std::uint32_t y = 0; y < kSide; ++y)
    for (std::uint32_t x = 0; x < kSide; ++x) {
      const std::uint32_t at = y * (kSide + 1) + x;
      mesh.triangles.push_back({at, at + 1, at + kSide + 1});
      mesh.triangles.push_back({at + 1, at + kSide + 2, at + kSide + 1});
    }
  const Rigid3 pose = LookAt({0.2, 0.1, 2}, Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitY());
  for ([[maybe_unused]] auto _ : state)
    benchmark::DoNotOptimize(MakeShadowMap(mesh, Studio().camera(), pose));
  state.counters["triangles"] = static_cast<double>(mesh.triangles.size());
}

CameraModel OutputCamera(const RenderScene& scene) {
  const CameraModel camera = scene.views.front().camera.WithoutDistortion();
  return camera.ScaledTo(camera.width / 2, camera.height / 2);
}

// From nothing to a picture, as a viewer opens: `complete`, or what is there after one photograph is.
void FirstPicture(benchmark::State& state, bool from_files, bool complete) {
  const fs::path dir = ManyViews();
  if (from_files) {  // what one picture left
    const auto scene = LoadScene(ReadLightField(dir), {});
    GlRenderer(scene, {}).Render(OutputCamera(*scene), scene->views[kViews / 2].cam_from_world);
  }
  PhotographStore::Counts counts;
  for ([[maybe_unused]] auto _ : state) {
    if (!from_files) {
      state.PauseTiming();
      fs::remove_all(dir / kPyramidFolder);
      state.ResumeTiming();
    }
    const auto scene = LoadScene(ReadLightField(dir), {});
    GlRenderer renderer(scene, {.complete = complete});
    renderer.Draw(OutputCamera(*scene), scene->views[kViews / 2].cam_from_world);
    counts = scene->store->counts();
  }
  state.counters["decoded"] = static_cast<double>(counts.decoded);
  state.counters["read"] = static_cast<double>(counts.levels_read);
}

// Along an orbit, moved in, where many views weigh; with so many thirds of what textures come to there.
void Frame(benchmark::State& state) {
  static const auto scene = LoadScene(ReadLightField(ManyViews()), {.memory_limit_mb = 8192});
  CameraPath path = OrbitPath(*scene, 16);
  for (Rigid3& pose : path.cam_from_world) {
    const Eigen::Vector3d center = pose.OriginInSource(), middle = scene->subject.center_in_world;
    pose = LookAt(middle + 0.5 * (center - middle), middle, scene->up_in_world);
  }
  const CameraModel camera = OutputCamera(*scene);
  static const std::size_t needed = [&] {
    GlRenderer renderer(scene, {.gpu_memory_mb = 8192});
    for (const Rigid3& pose : path.cam_from_world) renderer.Draw(camera, pose);
    return renderer.photograph_counts().most_bytes;
  }();
  const double limit_mb = 1e-6 * static_cast<double>(needed) * static_cast<double>(state.range(0)) / 3;
  GlRenderer renderer(scene, {.gpu_memory_mb = limit_mb});
  for (const Rigid3& pose : path.cam_from_world) renderer.Draw(camera, pose);
  const std::size_t before = renderer.photograph_counts().uploads;
  std::size_t frame = 0;
  for ([[maybe_unused]] auto _ : state)
    renderer.Draw(camera, path.cam_from_world[frame++ % path.cam_from_world.size()]);
  state.counters["uploads"] = static_cast<double>(renderer.photograph_counts().uploads - before) /
                              static_cast<double>(state.iterations());
  state.counters["limit_MB"] = limit_mb;
}

BENCHMARK_CAPTURE(Decode, png, ".png")->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(Decode, jpeg, ".jpg")->Unit(benchmark::kMillisecond);
BENCHMARK(Pyramid)->Unit(benchmark::kMillisecond);
BENCHMARK(WriteFile)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(ReadFile)->Arg(0)->Arg(1)->Arg(3)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(ShadowMapOfOneView)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(FirstPicture, without_files, false, true)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK_CAPTURE(FirstPicture, from_files, true, true)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK_CAPTURE(FirstPicture, without_files_at_once, false, false)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();
BENCHMARK(Frame)->Arg(3)->Arg(2)->Arg(1)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
}  // namespace ulf

int main(int argc, char** argv) { return ulf::RunBenchmarks(argc, argv); }
