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
#include "tests/charts/studio_views.h"
#include "tests/measure/runner.h"
#include "tests/measure/table.h"
#include "tests/support/floors.h"

namespace ulf::test {
namespace {

struct DrawnField {
  const char* name;
  FieldOptions field;
};

constexpr char kClock[] = "by the clock", kCpu[] = "processor time of all threads";

// Once round within a few degrees of the first view.
Eigen::Vector2d MouseAt(int frame, int frames, const cv::Size& size) {
  const double turn = 2 * M_PI * frame / frames, reach = 0.05 * size.width;
  return {0.5 * size.width + reach * std::sin(turn), 0.5 * size.height + reach * (1 - std::cos(turn))};
}

// A row of both panels: by the clock, and of the processor.
struct Row {
  std::string series;
  int width;
  bool is_default;
};

// Calls draw(frame) for the frames of each repetition.
template <typename Draw>
void Time(const Row& row, int repetitions, int frames, const Draw& draw, Table& table) {
  for (int r = 0; r < repetitions; ++r) {
    const double before_ms = ProcessCpuMs();
    const auto start = std::chrono::steady_clock::now();
    for (int frame = 0; frame < frames; ++frame) draw(frame);
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    table.Add(kClock, row.series, "", row.width, frames / seconds, row.is_default);
    table.Add(kCpu, row.series, "", row.width, (ProcessCpuMs() - before_ms) / frames, row.is_default);
  }
}

// Dragged about at full size, with its words and its sphere.
void TimeViewer(const std::shared_ptr<const RenderScene>& scene, const DrawnField& drawn,
                const cv::Size& size, const Effort& effort, Table& table, std::string& device) {
  OffscreenSurface surface(size);
  Viewer viewer(surface, scene,
                {.field = drawn.field,
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
  Time({fmt::format("viewer: {}", drawn.name), size.width, drawn.field.kind == FieldKind::kSubdivision},
       effort.Of(1, 3), frames, draw, table);
}

void TimeReference(const std::shared_ptr<const RenderScene>& scene, const DrawnField& drawn,
                   const cv::Size& size, const Effort& effort, Table& table) {
  const auto renderer = MakeRenderer(scene, {.field = drawn.field, .renderer = RendererKind::kReference});
  const ViewerCamera camera = StartingCamera(*scene);
  const auto draw = [&](int frame) {
    renderer->Render(camera.ModelFor(size), Orbited(camera, 0.02 * frame, 0.01 * frame).CamFromWorld());
  };
  draw(0);
  Time({fmt::format("reference renderer: {}", drawn.name), size.width, false}, effort.Of(1, 3), 2, draw,
       table);
}

Chart MeasureViewer(const Effort& effort) {
  const std::vector<DrawnField> fields{{"mesh, subdivision", {.kind = FieldKind::kSubdivision}},
                                       {"soft 0.5", {.kind = FieldKind::kSoft, .soft_width = kNarrowSoft}},
                                       {"soft 0.8", {.kind = FieldKind::kSoft, .soft_width = kWideSoft}}};
  const StudioOptions studio{
      .seed = kFirstSeed, .threshold_px = effort.Of(24.0, 12.0), .width = 960, .height = 640};
  const auto plain = StudioScene(studio);
  ProxyMesh geometry = BuildProxy(*plain, {.depth_maps = effort.Of(8, 60), .keep_maps = true});
  const auto scene =
      WithProxy(*plain, std::make_shared<SoftProxy>(plain->subject,
                                                    std::make_shared<TriangleMesh>(std::move(geometry.mesh)),
                                                    SoftProxy::InMemory(std::move(geometry.maps))));
  Table table;
  const ChartAxis cost{"a picture's width [px]", true};
  table.Panel(kClock, cost, MoreIsBetter(Log("frames a second")), {.compared = false});
  table.Panel(kCpu, cost, Log("a frame [ms, CPU]"), {.compared = false});
  std::string device;
  for (const DrawnField& drawn : fields)
    for (const int width : effort.Of(std::vector{320}, {160, 320, 640, 960, 1280}))
      TimeViewer(scene, drawn, {width, width * 9 / 16}, effort, table, device);
  for (const DrawnField& drawn : fields)
    for (const int width : effort.Of(std::vector{160}, {160, 320, 640}))
      if (drawn.field.kind != FieldKind::kSoft || drawn.field.soft_width != kNarrowSoft)
        TimeReference(scene, drawn, {width, width * 9 / 16}, effort, table);
  return {.found = fmt::format("{} photographs; the viewer on {}.", scene->views.size(), device),
          .panels = table.panels()};
}

CHART(viewer, MeasureViewer, "The viewer: frames a second over the mesh and with the soft field", R"(The
  simulated studio, photographs of 960 x 640 in memory, mesh and 60 depth maps at 480 pixels. The viewer is
  dragged about at full size, pictures of 16:9; the reference renderer draws single pictures on the
  processor. All in one run; what else runs, processor time hardly feels; bars: lowest to highest of the
  repetitions. Ringed: what the viewer begins with. Nothing was tuned on these views.)");

}  // namespace
}  // namespace ulf::test
