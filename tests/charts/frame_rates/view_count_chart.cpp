// What a picture costs as a light field grows: the fields against the number of views.
#include <algorithm>
#include <cmath>

#include "acquisition/simulator/simulated_camera.h"
#include "render/fields/field_options.h"
#include "render/gl/gl_renderer.h"
#include "tests/charts/makers.h"
#include "tests/charts/studio_views.h"
#include "tests/render/scenes/cap_scene.h"
#include "tests/render/scenes/synthetic_views.h"
#include "tests/support/floors.h"

namespace ulf::test {
namespace {

using Eigen::Vector3d;

struct FieldRow {
  const char* name;
  FieldOptions field;
  int most_views;  // more would take minutes a picture
};

std::vector<Rigid3> Places(int count) {
  std::vector<Rigid3> places;
  for (int i = 0; i < count; ++i) {
    const double turn = 2 * M_PI * i / count;
    const Vector3d direction = Vector3d(0.1 * std::cos(turn), 0.1 * std::sin(turn), 1).normalized();
    places.push_back(LookAt((i % 2 == 0 ? 1.3 : 0.6) * direction, Vector3d::Zero(), Vector3d::UnitY()));
  }
  return places;
}

struct PictureTime {
  Spread fps, cpu_ms;
};

// Once photographs are there and programs compiled; means over the places, medians of repetitions.
PictureTime TimePictures(GlRenderer& renderer, const std::vector<Rigid3>& places, int repetitions) {
  const CameraModel camera = CameraModel::Pinhole(640, 480, 320 / std::tan(20 * M_PI / 180));
  for (const Rigid3& place : places) renderer.Draw(camera, place);
  const auto count = static_cast<double>(places.size());
  std::vector<double> fps, cpu_ms;
  for (int r = 0; r < repetitions; ++r) {
    const double before = ProcessCpuMs();
    double ms = 0;
    for (const Rigid3& place : places) ms += renderer.Draw(camera, place);
    fps.push_back(1000 * count / ms);
    cpu_ms.push_back((ProcessCpuMs() - before) / count);
  }
  return {Spread::Of(fps), Spread::Of(cpu_ms)};
}

}  // namespace

Chart ViewCountChart(const ChartEffort& effort) {
  const std::vector<FieldRow> fields{
      {"linear", {.kind = FieldKind::kLinear}, 1600},
      {"subdivision", {.kind = FieldKind::kSubdivision, .level = 1}, 1600},
      {"lumigraph, at 2,000 triangles' corners", {.kind = FieldKind::kLumigraph}, 1600},
      {"lumigraph, at every pixel over all views",
       {.kind = FieldKind::kLumigraphPerPixel},
       effort.Of(25, 200)}};
  Chart chart;
  chart.title = "Rendering: pictures a second against the number of views";
  chart.about =
      "640 x 480 pixels, plane proxy, photographs of 960 x 640 in memory, views 5 degrees apart; places "
      "outside "
      "the viewpoints and moved in, in turn. All in one run; other programs ran on the processors, which "
      "processor time hardly feels; bars: "
      "lowest to highest of the repetitions. Nothing was tuned on these views.";
  ChartPanel clock{"by the clock", {"views", true}, {"pictures a second", true, true}, {}, false};
  ChartPanel cpu{"processor time of all threads", {"views", true}, {"a picture [ms, CPU]", true}, {}, false};
  for (const FieldRow& row : fields)
    for (const int count : effort.Of(std::vector{25, 200}, {25, 50, 100, 200, 400, 800, 1600})) {
      if (count > row.most_views) continue;
      GlRenderer renderer(CapScene(count), {.field = row.field});
      clock.title = "by the clock, " + renderer.Name();
      const bool is_default = row.field.kind == FieldKind::kSubdivision;
      const PictureTime time = TimePictures(renderer, Places(4), effort.Of(2, row.most_views < 1600 ? 2 : 7));
      clock.points.push_back(
          {row.name, fmt::format("{:.2g}", time.fps.median), Spread::Exactly(count), time.fps, is_default});
      cpu.points.push_back({row.name, fmt::format("{:.0f}", time.cpu_ms.median), Spread::Exactly(count),
                            time.cpu_ms, is_default});
    }
  chart.panels = {clock, cpu};
  return chart;
}

}  // namespace ulf::test
