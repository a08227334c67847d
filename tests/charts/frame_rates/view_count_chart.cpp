// What a picture costs as a light field grows: the fields against the number of views.
#include <cmath>

#include "acquisition/simulator/simulated_camera.h"
#include "render/fields/field_options.h"
#include "render/gl/gl_renderer.h"
#include "tests/charts/studio_views.h"
#include "tests/measure/runner.h"
#include "tests/measure/table.h"
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

constexpr char kClock[] = "by the clock", kCpu[] = "processor time of all threads";

// Once photographs are there and programs compiled; means over the places.
void TimePictures(const FieldRow& row, int views, const Effort& effort, Table& table, std::string& device) {
  GlRenderer renderer(CapScene(views), {.field = row.field});
  device = renderer.Name();
  const CameraModel camera = CameraModel::Pinhole(640, 480, 320 / std::tan(20 * M_PI / 180));
  const std::vector<Rigid3> places = Places(4);
  const auto count = static_cast<double>(places.size());
  const bool is_default = row.field.kind == FieldKind::kSubdivision;
  for (const Rigid3& place : places) renderer.Draw(camera, place);
  for (int r = 0; r < effort.Of(2, row.most_views < 1600 ? 2 : 7); ++r) {
    const double before = ProcessCpuMs();
    double ms = 0;
    for (const Rigid3& place : places) ms += renderer.Draw(camera, place);
    table.Add(kClock, row.name, "", views, 1000 * count / ms, is_default);
    table.Add(kCpu, row.name, "", views, (ProcessCpuMs() - before) / count, is_default);
  }
}

Chart MeasureViewCounts(const Effort& effort) {
  const std::vector<FieldRow> fields{
      {"linear", {.kind = FieldKind::kLinear}, 1600},
      {"subdivision", {.kind = FieldKind::kSubdivision, .level = 1}, 1600},
      {"lumigraph, at 2,000 triangles' corners", {.kind = FieldKind::kLumigraph}, 1600},
      {"lumigraph, at every pixel over all views",
       {.kind = FieldKind::kLumigraphPerPixel},
       effort.Of(25, 200)}};
  Table table;
  table.Panel(kClock, Log("views"), MoreIsBetter(Log("pictures a second")), {.compared = false});
  table.Panel(kCpu, Log("views"), Log("a picture [ms, CPU]"), {.compared = false});
  std::string device;
  for (const FieldRow& row : fields)
    for (const int count : effort.Of(std::vector{25, 200}, {25, 50, 100, 200, 400, 800, 1600}))
      if (count <= row.most_views) TimePictures(row, count, effort, table, device);
  return {.found = fmt::format("Drawn by {}.", device), .panels = table.panels()};
}

CHART(view_count, MeasureViewCounts, "Rendering: pictures a second against the number of views", R"(640 x
  480 pixels, plane proxy, photographs of 960 x 640 in memory, views 5 degrees apart; places outside the
  viewpoints and moved in, in turn. All in one run; other programs ran on the processors, which processor
  time hardly feels; bars: lowest to highest of the repetitions. Nothing was tuned on these views.)");

}  // namespace
}  // namespace ulf::test
