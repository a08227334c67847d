// Frames per second of the blending fields over the same photographs and proxy, 640x480 along a small orbit.
//   ULF_BENCH_LIGHT_FIELD=DIR ULF_BENCH_SUBJECT=x,y,z,r ./render_benchmark
// Without: shop_grid_even from the test data, where that is found, with its known subject.
#include <benchmark/benchmark.h>

#include <cstdio>
#include <cstdlib>

#include "acquisition/error.h"
#include "acquisition/light_field_io.h"
#include "render/camera_path.h"
#include "render/gl_renderer.h"
#include "render/image_triangulation.h"
#include "render/mesh_field.h"
#include "tests/support/test_paths.h"

namespace ulf {
namespace {

constexpr int kFrames = 16;

std::shared_ptr<const RenderScene> BenchScene() {
  static const std::shared_ptr<const RenderScene> scene = [] {
    std::filesystem::path dir;
    SceneOptions options;
    if (const char* given = std::getenv("ULF_BENCH_LIGHT_FIELD")) {
      dir = given;
      double x = 0, y = 0, z = 0, r = 0;
      const char* subject = std::getenv("ULF_BENCH_SUBJECT");
      if (subject && std::sscanf(subject, "%lf,%lf,%lf,%lf", &x, &y, &z, &r) == 4)
        options.subject = {{x, y, z}, r};
    } else if (const auto found = test::TestData("shop_grid_even")) {
      dir = *found;
      options.subject = Subject{{0, 0, -8.12}, 1.5};
    } else {
      throw Error("no light field to measure on: set ULF_BENCH_LIGHT_FIELD");
    }
    return LoadScene(ReadLightField(dir), options);
  }();
  return scene;
}

CameraModel BenchCamera(const RenderScene& scene) {
  return CameraModel::Pinhole(640, 480,
                              640.0 / scene.views.front().camera.width * scene.views.front().camera.fx);
}

GlRenderer& BenchRenderer() {
  static GlRenderer renderer(BenchScene(), {});
  return renderer;
}

void Field(benchmark::State& state, FieldOptions field) {
  GlRenderer& renderer = BenchRenderer();
  renderer.SetField(field);
  const CameraModel camera = BenchCamera(renderer.scene());
  const CameraPath path = OrbitPath(renderer.scene(), kFrames);
  renderer.Draw(camera, path.cam_from_world[0]);
  std::size_t frame = 0;
  for (auto _ : state) renderer.Draw(camera, path.cam_from_world[frame++ % kFrames]);
  state.counters["fps"] =
      benchmark::Counter(static_cast<double>(state.iterations()), benchmark::Counter::kIsRate);
  state.SetLabel(renderer.Name());
}

// What of a frame is spent on the CPU before anything is drawn.
void MeshPlacement(benchmark::State& state) {
  const auto scene = BenchScene();
  const MeshField field(scene, static_cast<int>(state.range(0)));
  const CameraPath path = OrbitPath(*scene, kFrames);
  std::size_t frame = 0;
  for (auto _ : state)
    benchmark::DoNotOptimize(field.Place(path.cam_from_world[frame++ % kFrames].OriginInSource()));
}

void LumigraphWeightsAtVertices(benchmark::State& state) {
  const auto scene = BenchScene();
  const CameraModel camera = BenchCamera(*scene);
  const CameraPath path = OrbitPath(*scene, kFrames);
  std::size_t frame = 0, triangles = 0;
  for (auto _ : state) {
    const Rigid3& pose = path.cam_from_world[frame++ % kFrames];
    const PlaneInCamera plane = scene->proxy->Background(pose);
    const auto depth_at = [&](const Eigen::Vector2d& img) {
      return plane.DepthOf({(img.x() - camera.cx) / camera.fx, (img.y() - camera.cy) / camera.fy, 1.0});
    };
    triangles = TriangulateLumigraph(*scene, camera, pose, depth_at, {}).triangles.size();
  }
  state.counters["triangles"] = static_cast<double>(triangles);
}

#define ULF_FIELD_BENCHMARK(name, ...)                     \
  BENCHMARK_CAPTURE(Field, name, FieldOptions __VA_ARGS__) \
      ->UseRealTime()                                      \
      ->Unit(benchmark::kMillisecond)                      \
      ->MinTime(2)

ULF_FIELD_BENCHMARK(nearest, {.kind = FieldKind::kNearest});
ULF_FIELD_BENCHMARK(linear, {.kind = FieldKind::kLinear});
ULF_FIELD_BENCHMARK(subdivision_1, {.kind = FieldKind::kSubdivision, .level = 1});
ULF_FIELD_BENCHMARK(subdivision_2, {.kind = FieldKind::kSubdivision, .level = 2});
ULF_FIELD_BENCHMARK(lumigraph_at_vertices, {.kind = FieldKind::kLumigraph});
ULF_FIELD_BENCHMARK(lumigraph_per_pixel, {.kind = FieldKind::kLumigraphPerPixel});
BENCHMARK(MeshPlacement)->Arg(0)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond);
BENCHMARK(LumigraphWeightsAtVertices)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace ulf

BENCHMARK_MAIN();
