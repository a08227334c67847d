// What a picture costs, as ratios of times that were measured in turn in one run: two processors that others
// use, too, are no clock. Of each picture of a path the fastest of some repetitions counts.
//
// The photographs are one of the simulated studio under many names, at viewpoints as far apart from each
// other whatever their number, on a cap or, 1,600 of them, all around; their light does not matter here.
//   ULF_BENCH_LIGHT_FIELD=DIR ULF_BENCH_SUBJECT=x,y,z,r ./render_benchmark
// measures the fields on a light field, too. Without: shop_grid_even from the test data, where that is found.
#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <vector>

#include "acquisition/simulator/simulated_camera.h"
#include "core/base/error.h"
#include "core/light_field/folder/light_field_io.h"
#include "render/fields/field_options.h"
#include "render/fields/image_triangulation.h"
#include "render/fields/lumigraph_field.h"
#include "render/fields/mesh_field.h"
#include "render/gl/gl_context.h"
#include "render/gl/gl_renderer.h"
#include "render/output/camera_path.h"
#include "tests/measure/figures.h"
#include "tests/measure/paired.h"
#include "tests/render/scenes/cap_scene.h"
#include "tests/render/scenes/synthetic_views.h"
#include "tests/support/floors.h"
#include "tests/support/test_paths.h"

namespace ulf {
namespace {

constexpr FieldOptions kNearest{.kind = FieldKind::kNearest}, kLinear{.kind = FieldKind::kLinear},
    kSubdivision{.kind = FieldKind::kSubdivision, .level = 1},
    kSubdivision2{.kind = FieldKind::kSubdivision, .level = 2}, kPerVertex{.kind = FieldKind::kLumigraph},
    kPerPixel{.kind = FieldKind::kLumigraphPerPixel};

constexpr int kRepetitions = 3;
constexpr double kGpuSeconds =
    2;  // repeated for so long: the clock of a GPU that was idle takes a second to rise

bool IsOnGpu() {
  static const bool on_gpu = !GlContext().IsSoftware();
  return on_gpu;
}

using Scene = std::shared_ptr<const RenderScene>;
using test::CapScene;
using test::kWhole;

// Around the middle of the cap, in turn outside the viewpoints and moved in.
std::vector<Rigid3> CapPath() {
  std::vector<Rigid3> path;
  for (int i = 0; i < 4; ++i) {
    const double a = 2 * M_PI * i / 4, distance = i % 2 == 0 ? 1.3 : 0.6;
    const Eigen::Vector3d off(0.1 * std::cos(a), 0.1 * std::sin(a), 1);
    path.push_back(LookAt(distance * off.normalized(), Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitY()));
  }
  return path;
}

// 40 degrees wide.
CameraModel CapCamera(int width, int height) {
  return CameraModel::Pinhole(width, height, 0.5 * width / std::tan(20 * M_PI / 180));
}

struct Contender {
  GlRenderer* renderer;
  FieldOptions field;
};

struct Measured {
  double ms = 0;      // of a picture, by the clock
  double cpu_ms = 0;  // the same of all processors' time
};
using Pictures = std::vector<Measured>;  // of a path

Pictures DrawPath(const Contender& contender, const CameraModel& camera, const std::vector<Rigid3>& path) {
  contender.renderer->SetField(contender.field);
  Pictures pictures;
  for (const Rigid3& pose : path) {
    const double before = CpuSeconds();
    const double ms = contender.renderer->Draw(camera, pose);
    pictures.push_back({ms, 1000 * (CpuSeconds() - before)});
  }
  return pictures;
}

// Means over the path, of the fastest of each picture's repetitions.
std::vector<Measured> Measure(const std::vector<Contender>& contenders, const CameraModel& camera,
                              const std::vector<Rigid3>& path) {
  std::vector<std::function<Pictures()>> turns;
  for (const Contender& contender : contenders) {
    DrawPath(contender, camera, path);  // photographs are read and programs compiled
    turns.emplace_back([&] { return DrawPath(contender, camera, path); });
  }
  const auto start = Clock::now();
  const auto rounds = test::InTurn<Pictures>(turns, [&](std::size_t done) {
    return done < kRepetitions || (IsOnGpu() && SecondsSince(start) < kGpuSeconds);
  });
  const auto mean_of_fastest = [&](const std::vector<Pictures>& of, double Measured::*value) {
    double sum = 0;
    for (std::size_t i = 0; i < path.size(); ++i)
      sum += std::ranges::min(of, {}, [&](const Pictures& pictures) { return pictures[i].*value; })[i].*value;
    return sum / static_cast<double>(path.size());
  };
  std::vector<Measured> measured;
  for (const auto& of : rounds)
    measured.push_back({mean_of_fastest(of, &Measured::ms), mean_of_fastest(of, &Measured::cpu_ms)});
  return measured;
}

// By the clock, and of processor time, which others on the machine disturb less.
void TellRatio(benchmark::State& state, const Measured& slower, const Measured& faster) {
  state.counters["ms"] = slower.ms;
  state.counters["against_ms"] = faster.ms;
  state.counters["ratio"] = slower.ms / faster.ms;
  state.counters["cpu_ms"] = slower.cpu_ms;
  state.counters["against_cpu_ms"] = faster.cpu_ms;
  state.counters["cpu_ratio"] = slower.cpu_ms / faster.cpu_ms;
}

// One field over another, at a number of views.
void OverAt(benchmark::State& state, int views, const FieldOptions& slower, const FieldOptions& faster) {
  GlRenderer renderer(CapScene(views), {});
  for ([[maybe_unused]] auto _ : state) {
    const auto measured = Measure({{&renderer, slower}, {&renderer, faster}}, CapCamera(640, 480), CapPath());
    TellRatio(state, measured[0], measured[1]);
  }
  state.SetLabel(renderer.Name());
}

// Weights per pixel over all views, as SIBR's renderer of unstructured lumigraphs has them.
void SubdivisionAgainstPerPixel(benchmark::State& state) { OverAt(state, 183, kPerPixel, kSubdivision); }

void SubdivisionAgainstPerVertex(benchmark::State& state) {
  OverAt(state, static_cast<int>(state.range(0)), kPerVertex, kSubdivision);
}

void SubdivisionAgainstLinear(benchmark::State& state) { OverAt(state, 200, kSubdivision, kLinear); }

void ManyViewsAgainstFew(benchmark::State& state) {
  GlRenderer few(CapScene(200), {}), many(CapScene(kWhole), {});
  for ([[maybe_unused]] auto _ : state) {
    const auto measured =
        Measure({{&many, kSubdivision}, {&few, kSubdivision}}, CapCamera(640, 480), CapPath());
    TellRatio(state, measured[0], measured[1]);
  }
  state.SetLabel(few.Name());
}

void TellPictures(benchmark::State& state, GlRenderer& renderer, const CameraModel& camera,
                  const std::vector<Rigid3>& path) {
  const Measured measured = Measure({{&renderer, kSubdivision}}, camera, path)[0];
  state.counters["ms"] = measured.ms;
  state.counters["cpu_ms"] = measured.cpu_ms;
  state.counters["fps"] = 1000 / measured.ms;
}

void PicturesASecond(benchmark::State& state, int views, const cv::Size& photographs, const cv::Size& size,
                     bool only_on_gpu) {
  if (only_on_gpu && !IsOnGpu()) {
    state.SkipWithError("there is no GPU here");
    return;
  }
  GlRenderer renderer(CapScene(views, photographs), {});
  for ([[maybe_unused]] auto _ : state) {
    TellPictures(state, renderer, CapCamera(size.width, size.height), CapPath());
  }
  state.SetLabel(renderer.Name());
}

// Skips the benchmark where none is given and none is found.
Scene GivenScene(benchmark::State& state) {
  static const Scene scene = []() -> Scene {
    if (const char* given = std::getenv("ULF_BENCH_LIGHT_FIELD")) {
      SceneOptions options;
      double x = 0, y = 0, z = 0, r = 0;
      const char* subject = std::getenv("ULF_BENCH_SUBJECT");
      if (subject && std::sscanf(subject, "%lf,%lf,%lf,%lf", &x, &y, &z, &r) == 4)
        options.subject = {{x, y, z}, r};
      return LoadScene(ReadLightField(given), options);
    }
    const auto found = test::TestData("shop_grid_even");
    return found ? LoadScene(ReadLightField(*found), {.subject = Subject{{0, 0, -8.12}, 1.5}}) : nullptr;
  }();
  if (scene)
    state.counters["views"] = static_cast<double>(scene->views.size());
  else
    state.SkipWithError("no light field to measure on: set ULF_BENCH_LIGHT_FIELD");
  return scene;
}

// All fields in turn, 640 wide, along an orbit.
void GivenLightField(benchmark::State& state) {
  const Scene scene = GivenScene(state);
  if (!scene) return;
  GlRenderer renderer(scene, {});
  const CameraModel& of_views = scene->views.front().camera;
  const CameraModel camera = CameraModel::Pinhole(640, 480, 640.0 / of_views.width * of_views.fx);
  const std::vector<std::pair<const char*, FieldOptions>> fields{
      {"nearest", kNearest},           {"linear", kLinear},
      {"subdivision_1", kSubdivision}, {"subdivision_2", kSubdivision2},
      {"per_vertex", kPerVertex},      {"per_pixel", kPerPixel}};
  std::vector<Contender> contenders;
  for (const auto& [name, field] : fields) contenders.push_back({&renderer, field});
  for ([[maybe_unused]] auto _ : state) {
    const auto measured = Measure(contenders, camera, OrbitPath(*scene, 4).cam_from_world);
    for (std::size_t i = 0; i < fields.size(); ++i)
      state.counters[fmt::format("{}_ms", fields[i].first)] = measured[i].ms;
  }
}

// As SIBR's renderer of unstructured lumigraphs was measured: 680 x 453, between the views of a grid.
void BetweenViews(benchmark::State& state) {
  const Scene scene = GivenScene(state);
  if (!scene) return;
  GlRenderer renderer(scene, {});
  const CameraModel& of_views = scene->views.front().camera;
  const CameraModel camera = CameraModel::Pinhole(680, 453, 680.0 / of_views.width * of_views.fx);
  std::vector<Rigid3> path;
  constexpr std::size_t kPictures = 12;
  for (std::size_t i = 0; i < kPictures; ++i) {
    const SceneView& view = scene->views[i * scene->views.size() / kPictures];
    Rigid3 pose = view.cam_from_world;
    const int neighbour = ViewsByDistance(*scene, view.center_in_world)[1];
    const Eigen::Vector3d center =
        0.5 * (view.center_in_world + scene->views[static_cast<std::size_t>(neighbour)].center_in_world);
    pose.translation = -(pose.rotation * center);
    path.push_back(pose);
  }
  for ([[maybe_unused]] auto _ : state) {
    TellPictures(state, renderer, camera, path);
  }
  state.SetLabel(renderer.Name());
}

// What of a frame is spent on the processor before anything is drawn.
void MeshPlacement(benchmark::State& state) {
  const Scene scene = CapScene(static_cast<int>(state.range(0)));
  const MeshField field(scene, static_cast<int>(state.range(1)));
  const std::vector<Rigid3> path = CapPath();
  std::size_t frame = 0;
  for ([[maybe_unused]] auto _ : state)
    benchmark::DoNotOptimize(field.Place(path[frame++ % path.size()].OriginInSource()));
}

void LumigraphWeightsAtVertices(benchmark::State& state) {
  const Scene scene = CapScene(static_cast<int>(state.range(0)));
  const CameraModel camera = CapCamera(640, 480);
  const std::vector<Rigid3> path = CapPath();
  std::size_t frame = 0, triangles = 0;
  for ([[maybe_unused]] auto _ : state) {
    const Rigid3& pose = path[frame++ % path.size()];
    const PlaneInCamera plane = scene->proxy->Background(pose);
    const auto depth_at = [&](const Eigen::Vector2d& img) {
      return plane.DepthOf({(img.x() - camera.cx) / camera.fx, (img.y() - camera.cy) / camera.fy, 1.0});
    };
    triangles = TriangulateLumigraph(*scene, camera, pose, depth_at, {.lumigraph_k = 4}).triangles.size();
  }
  state.counters["triangles"] = static_cast<double>(triangles);
}

BENCHMARK(SubdivisionAgainstPerPixel)->Iterations(1)->Unit(benchmark::kMillisecond);
BENCHMARK(SubdivisionAgainstPerVertex)
    ->Arg(25)
    ->Arg(50)
    ->Arg(100)
    ->Arg(200)
    ->Arg(400)
    ->Arg(800)
    ->Arg(kWhole)
    ->Iterations(1)
    ->Unit(benchmark::kMillisecond);
BENCHMARK(ManyViewsAgainstFew)->Iterations(1)->Unit(benchmark::kMillisecond);
BENCHMARK(SubdivisionAgainstLinear)->Iterations(1)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(PicturesASecond, 200_views_720p, 200, cv::Size(960, 640), cv::Size(1280, 720), false)
    ->Iterations(1)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(PicturesASecond, 800_views_1080p_gpu, 800, cv::Size(1152, 864), cv::Size(1920, 1080), true)
    ->Iterations(1)
    ->Unit(benchmark::kMillisecond);
BENCHMARK(GivenLightField)->Iterations(1)->Unit(benchmark::kMillisecond);
BENCHMARK(BetweenViews)->Iterations(1)->Unit(benchmark::kMillisecond);
BENCHMARK(MeshPlacement)->ArgsProduct({{200, kWhole}, {0, 1, 2}})->Unit(benchmark::kMillisecond);
BENCHMARK(LumigraphWeightsAtVertices)->Arg(200)->Arg(kWhole)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace ulf

int main(int argc, char** argv) {
  const bool on_gpu = ulf::IsOnGpu();
  std::vector<ulf::Target> targets{
      {"SubdivisionAgainstPerPixel", "ratio", 15, "times as fast as weights per pixel over 183 views"},
      {.run = "ManyViewsAgainstFew",
       .counter = "ratio",
       .what = "time at 1,600 views over that at 200",
       .at_most = 1.25},
      {.run = "SubdivisionAgainstLinear",
       .counter = "ratio",
       .what = "time over that of linear weights",
       .at_most = on_gpu ? 1.2 : 2.3},
      {"PicturesASecond/200_views_720p", "fps", 30, "pictures of 1280 x 720 a second, 200 views"}};
  if (on_gpu)
    targets.push_back(
        {"PicturesASecond/800_views_1080p_gpu", "fps", 300, "pictures of 1920 x 1080 a second, 800 views"});
  if (ulf::test::TestData("shop_grid_even") && !std::getenv("ULF_BENCH_LIGHT_FIELD"))
    targets.push_back({"BetweenViews", "fps", 50 * 0.94,
                       "pictures of 680 x 453 a second of shop_grid_even, 50 times SIBR's 0.94"});
  return ulf::RunBenchmarks(argc, argv, targets);
}
