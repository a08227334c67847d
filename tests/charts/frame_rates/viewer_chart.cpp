// What is seen in a second of moving about: the viewer over the mesh and with the soft field, beside the
// reference renderer's pictures, by size.
#include <chrono>
#include <cmath>
#include <optional>

#include "render/fields/field_options.h"
#include "render/gl/gl_renderer.h"
#include "render/proxy/soft_proxy.h"
#include "render/stereo/proxy_builder.h"
#include "render/viewer/viewer.h"
#include "tests/charts/makers.h"
#include "tests/charts/studio_views.h"
#include "tests/support/floors.h"

namespace ulf::test {
namespace {

struct DrawnField {
  const char* name;
  FieldOptions field;
};

struct FrameTimes {
  std::vector<double> fps, cpu_ms;  // of the repetitions
};

// Once round within a few degrees of the first view.
Eigen::Vector2d MouseAt(int frame, int frames, const cv::Size& size) {
  const double turn = 2 * M_PI * frame / frames, reach = 0.05 * size.width;
  return {0.5 * size.width + reach * std::sin(turn), 0.5 * size.height + reach * (1 - std::cos(turn))};
}

// Calls draw(frame) for the frames of a repetition.
template <typename Draw>
FrameTimes Time(int repetitions, int frames, const Draw& draw) {
  FrameTimes times;
  for (int r = 0; r < repetitions; ++r) {
    const double before_ms = ProcessCpuMs();
    const auto start = std::chrono::steady_clock::now();
    for (int frame = 0; frame < frames; ++frame) draw(frame);
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    times.fps.push_back(frames / seconds);
    times.cpu_ms.push_back((ProcessCpuMs() - before_ms) / frames);
  }
  return times;
}

// Dragged about at full size, with its words and its sphere.
FrameTimes TimeViewer(const std::shared_ptr<const RenderScene>& scene, const FieldOptions& field,
                      const cv::Size& size, const ChartEffort& effort, std::string& device) {
  OffscreenSurface surface(size);
  Viewer viewer(surface, scene,
                {.field = field,
                 .proxies = {{"soft", [proxy = scene->proxy] { return proxy; }}},
                 .reduces_motion = false});
  device = viewer.renderer().Name();
  const int frames = effort.Of(4, 8);
  surface.Push(MouseMoved{MouseAt(0, frames, size)});
  surface.Push(MouseButton{0, true});
  const auto draw = [&](int frame) {
    surface.Push(MouseMoved{MouseAt(frame + 1, frames, size)});
    viewer.Step(0);
  };
  for (int frame = 0; frame < frames; ++frame) draw(frame);
  while (viewer.loading()) viewer.Step(0.1);
  return Time(effort.Of(1, 3), frames, draw);
}

FrameTimes TimeReference(const std::shared_ptr<const RenderScene>& scene, const FieldOptions& field,
                         const cv::Size& size, const ChartEffort& effort) {
  const auto renderer = MakeRenderer(scene, {.field = field, .renderer = RendererKind::kReference});
  const ViewerCamera camera = StartingCamera(*scene);
  const auto draw = [&](int frame) {
    renderer->Render(camera.ModelFor(size), Orbited(camera, 0.02 * frame, 0.01 * frame).CamFromWorld());
  };
  draw(0);
  return Time(effort.Of(1, 3), 2, draw);
}

}  // namespace

Chart ViewerChart(const ChartEffort& effort) {
  const std::vector<DrawnField> fields{{"mesh, subdivision", {.kind = FieldKind::kSubdivision}},
                                       {"soft 0.5", {.kind = FieldKind::kSoft, .soft_width = kNarrowSoft}},
                                       {"soft 0.8", {.kind = FieldKind::kSoft, .soft_width = kWideSoft}}};
  const StudioOptions studio{.threshold_px = effort.Of(24.0, 12.0), .width = 960, .height = 640};
  const auto plain = StudioScene(studio);
  ProxyMesh geometry = BuildProxy(*plain, {.depth_maps = effort.Of(8, 60), .keep_maps = true});
  const auto scene =
      WithProxy(*plain, std::make_shared<SoftProxy>(plain->subject,
                                                    std::make_shared<TriangleMesh>(std::move(geometry.mesh)),
                                                    SoftProxy::InMemory(std::move(geometry.maps))));
  ChartPanel clock{
      "by the clock", {"a picture's width [px]", true}, {"frames a second", true, true}, {}, false};
  ChartPanel cpu{"processor time of all threads",
                 {"a picture's width [px]", true},
                 {"a frame [ms, CPU]", true},
                 {},
                 false};
  const auto add = [&](const std::string& series, const cv::Size& size, const FrameTimes& times,
                       bool is_default) {
    const Spread fps = Spread::Of(times.fps), cpu_ms = Spread::Of(times.cpu_ms);
    clock.points.push_back(
        {series, fmt::format("{:.2g}", fps.median), Spread::Exactly(size.width), fps, is_default});
    cpu.points.push_back(
        {series, fmt::format("{:.0f}", cpu_ms.median), Spread::Exactly(size.width), cpu_ms, is_default});
  };
  std::string device;
  for (const auto& [name, field] : fields)
    for (const int width : effort.Of(std::vector{320}, {160, 320, 640, 960, 1280})) {
      const cv::Size size(width, width * 9 / 16);
      add(fmt::format("viewer: {}", name), size, TimeViewer(scene, field, size, effort, device),
          field.kind == FieldKind::kSubdivision);
    }
  for (const auto& [name, field] : fields)
    for (const int width : effort.Of(std::vector{160}, {160, 320, 640})) {
      if (field.soft_width == kNarrowSoft && field.kind == FieldKind::kSoft) continue;
      const cv::Size size(width, width * 9 / 16);
      add(fmt::format("reference renderer: {}", name), size, TimeReference(scene, field, size, effort),
          false);
    }
  Chart chart;
  chart.title = "The viewer: frames a second over the mesh and with the soft field";
  chart.about = fmt::format(
      "The simulated studio, seed 1, {} photographs of 960 x 640 in memory, mesh and {} depth maps at 480 "
      "pixels. The viewer on {} is dragged about at full size, pictures of 16:9; the reference renderer "
      "draws "
      "single pictures on the processor. All in one run; what else runs, "
      "processor time hardly feels; bars: lowest to highest of the repetitions. Ringed: what the viewer "
      "begins with. Nothing was tuned on these views.",
      scene->views.size(), effort.Of(8, 60), device);
  chart.panels = {clock, cpu};
  return chart;
}

}  // namespace ulf::test
