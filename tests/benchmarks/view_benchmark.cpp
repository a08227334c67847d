// The viewer at 1280x720, on a GPU or with software OpenGL on all processors: what a frame costs while
// somebody drags the camera round a subject of 200 views, with words and sphere, at full size and as large as
// keeps up, over the plane and over a mesh of it with depth maps, and how long `ulf view` takes from its
// start to the first picture of 800 views. Photographs are 1280x720, made up.
#include <benchmark/benchmark.h>

#include <cstdlib>
#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>
#include <string_view>

#include "core/base/json_text.h"
#include "core/light_field/folder/light_field_io.h"
#include "core/light_field/folder/light_field_writer.h"
#include "render/fields/field_options.h"
#include "render/proxy/soft_proxy.h"
#include "render/viewer/viewer.h"
#include "tests/measure/figures.h"
#include "tests/render/scenes/synthetic_views.h"
#include "tests/support/floors.h"
#include "tests/support/test_paths.h"

namespace ulf {
namespace {

constexpr int kViews = 800;
const cv::Size kSize(1280, 720);

// Soft noise: it compresses as photographs do.
cv::Mat Photograph(int seed) {
  cv::RNG random(static_cast<std::uint64_t>(seed) + 1);
  cv::Mat coarse(kSize.height / 16, kSize.width / 16, CV_8UC3), grain(kSize, CV_8UC3), picture;
  random.fill(coarse, cv::RNG::UNIFORM, 30, 220);
  random.fill(grain, cv::RNG::UNIFORM, 0, 8);
  cv::resize(coarse, picture, kSize, 0, 0, cv::INTER_CUBIC);
  return picture + grain;
}

const std::filesystem::path& LightFieldOf800() {
  static const test::ScratchFolder scratch;
  static const std::filesystem::path dir = [] {
    CaptureHeader header;
    header.camera = CameraModel::Pinhole(kSize.width, kSize.height, 1100);
    auto writer = LightFieldWriter::Create(scratch / "lf", header);
    int seed = 0;
    for (const Eigen::Vector3d& center : test::CapViewpoints(kViews, 0.5, 2.0, 0.02)) {
      View view;
      view.cam_from_world = LookAt(center, Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitY());
      Frame frame;
      frame.image = {.pixels = Photograph(seed), .transfer = Transfer::kSrgb};
      frame.id = static_cast<std::uint64_t>(seed++);
      writer.AddView(frame, view);
    }
    writer.SetSubject({Eigen::Vector3d::Zero(), 0.3});
    writer.Close(1.0);
    return scratch / "lf";
  }();
  return dir;
}

std::shared_ptr<const RenderScene> SceneOf200() {
  static const auto scene = [] {
    SceneOptions options{.memory_limit_mb = 4096};
    for (int i = 0; i < kViews; ++i)
      if (i % 4 != 0) options.leave_out.push_back(i);
    return LoadScene(ReadLightField(LightFieldOf800()), options);
  }();
  return scene;
}

// The plane through the subject as a mesh of triangles as large as those of `ulf proxy`, and as each view
// sees it. What photographs and depths show does not matter to the time.
std::shared_ptr<const Proxy> MeshAndMaps() {
  static const auto proxy = [] {
    constexpr unsigned kSide = 300;
    constexpr float kHalf = 1.5f;
    auto mesh = std::make_shared<TriangleMesh>();
    for (unsigned y = 0; y <= kSide; ++y)
      for (unsigned x = 0; x <= kSide; ++x)
        mesh->vertices.emplace_back(kHalf * (2.0f * static_cast<float>(x) / kSide - 1),
                                    kHalf * (2.0f * static_cast<float>(y) / kSide - 1), 0.0f);
    for (unsigned y = 0; y < kSide; ++y)
      for (unsigned x = 0; x < kSide; ++x) {
        const unsigned corner = y * (kSide + 1) + x;
        mesh->triangles.push_back({corner, corner + 1, corner + kSide + 2});
        mesh->triangles.push_back({corner, corner + kSide + 2, corner + kSide + 1});
      }
    return std::make_shared<SoftProxy>(SceneOf200()->subject, mesh, SoftProxy::Maps{});
  }();
  return proxy;
}

struct Dragged {
  FieldOptions field = {};
  const char* keys = "";
  bool keeps_up = false, over_mesh = false;
};

void Drag(benchmark::State& state, const Dragged& dragged) {
  const auto scene = SceneOf200();
  OffscreenSurface surface(kSize);
  const Subject subject = scene->subject;
  const OfferedProxy plane{"plane", [subject] { return std::make_shared<PlaneProxy>(subject); }},
      mesh{"soft", [] { return MeshAndMaps(); }};
  Viewer viewer(surface, scene,
                {.field = dragged.field,
                 .proxies = {dragged.over_mesh ? mesh : plane},
                 .reduces_motion = dragged.keeps_up});
  for (const char key : std::string_view(dragged.keys)) surface.Push(Typed{static_cast<char32_t>(key)});
  surface.Push(MouseMoved{{640, 360}});
  surface.Push(MouseButton{0, true});
  viewer.Step(0);
  int frame = 0;
  const auto move = [&] {  // round in a circle, inside the hull
    const double phase = 2 * M_PI * frame++ / 60;
    surface.Push(MouseMoved{{640 + 60 * std::sin(phase), 360 + 60 * (1 - std::cos(phase))}});
    viewer.Step(0);
  };
  for (int i = 0; i < 60; ++i) move();  // what is seen is in memory then
  const auto start = Clock::now();
  int frames = 0;
  for ([[maybe_unused]] auto _ : state) {
    move();
    ++frames;
  }
  const double seconds = SecondsSince(start);
  state.counters["fps"] = frames / seconds;
  state.counters["ms_a_frame"] = 1000 * seconds / frames;
  state.counters["width"] = viewer.drawn_size().width;
  state.SetLabel(viewer.renderer().Name());
}

void FirstPicture(benchmark::State& state) {
  const std::string dir = LightFieldOf800().string();
  const test::ScratchFolder scratch;
  for ([[maybe_unused]] auto _ : state) {
    const auto result = test::RunUlf("view " + dir + " --json --screenshot " + (scratch / "a.png").string());
    if (result.exit_code != 0) {
      state.SkipWithError(result.errors.c_str());
      return;
    }
    const double seconds = JsonFromText(result.output)["first_picture_s"];
    state.counters["seconds"] = seconds;
    state.counters["of_2_s"] = 2 / seconds;
  }
}

// In this order: the second run finds what the first has left under cache/.
BENCHMARK(FirstPicture)->Name("FirstPictureOf800")->Iterations(1)->Unit(benchmark::kMillisecond);
BENCHMARK(FirstPicture)->Name("SecondTimeOf800")->Iterations(1)->Unit(benchmark::kMillisecond);
void DragFor(const char* name, int frames, const Dragged& dragged) {
  benchmark::RegisterBenchmark((std::string("Drag/") + name).c_str(), Drag, dragged)
      ->Iterations(frames)
      ->Unit(benchmark::kMillisecond);
}

const bool kRegistered = [] {
  const FieldOptions linear{.kind = FieldKind::kLinear}, soft{.kind = FieldKind::kSoft};
  DragFor("subdivision_1", 120, {});
  DragFor("keeping_up", 120, {.keeps_up = true});
  DragFor("linear", 120, {.field = linear});
  DragFor("subdivision_1_with_mesh", 120, {.keys = "m"});
  DragFor("over_mesh", 60, {.over_mesh = true});
  DragFor("soft", 20, {.field = soft, .over_mesh = true});
  DragFor("soft_keeping_up", 60, {.field = soft, .keeps_up = true, .over_mesh = true});
  return true;
}();

}  // namespace
}  // namespace ulf

int main(int argc, char** argv) {
  setenv("ULF_BINARY", ULF_BINARY, 1);
  return ulf::RunBenchmarks(
      argc, argv,
      {{"Drag/subdivision_1", "fps", 30, "frames a second of the viewer, 200 views, 1280x720"},
       {"FirstPictureOf800", "of_2_s", 1, "two seconds over the time to the first picture of 800 views"},
       {"SecondTimeOf800", "of_2_s", 1, "the same when it has been looked at before"}});
}
