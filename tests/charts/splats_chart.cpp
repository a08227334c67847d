// What Gaussians without training are worth (`ulf export splat`): pictures of left-out views, by how many
// there may be, beside the mesh and the soft field over the same geometry. Sets of the test data that are not
// found are left out. A line for each set goes to standard output.
#include <cstdio>
#include <filesystem>
#include <functional>
#include <opencv2/imgproc.hpp>

#include "core/base/progress.h"
#include "core/image/image.h"
#include "render/fields/field_options.h"
#include "render/gl/gl_renderer.h"
#include "render/proxy/proxy.h"
#include "render/proxy/soft_proxy.h"
#include "render/quality/light_fit.h"
#include "render/quality/quality.h"
#include "render/scene/even_picture.h"
#include "render/splats/make_splats.h"
#include "render/splats/splat_renderer.h"
#include "render/stereo/proxy_builder.h"
#include "tests/charts/left_out_sets.h"
#include "tests/measure/cpu_time.h"
#include "tests/measure/runner.h"
#include "tests/measure/table.h"
#include "tests/support/test_paths.h"

namespace ulf::test {
namespace {

namespace fs = std::filesystem;

// A photograph that is left out, on the common scale of light, and which of its pixels have any.
struct LeftOutPhotograph {
  CameraModel camera;  // without distortion
  Rigid3 cam_from_world;
  cv::Mat bgr, valid;
};

LeftOutPhotograph PhotographOf(const SceneView& view) {
  const Undistortion undistortion = UndistortionOf(view);
  LeftOutPhotograph photograph{
      undistortion.to, view.cam_from_world, EvenPicture(view, undistortion, undistortion.to), {}};
  photograph.valid = cv::Mat(photograph.bgr.size(), CV_8U, cv::Scalar(255));
  if (photograph.bgr.channels() == 4) {
    cv::extractChannel(photograph.bgr, photograph.valid, 3);
    photograph.valid = photograph.valid == 255;
    cv::cvtColor(photograph.bgr, photograph.bgr, cv::COLOR_BGRA2BGR);
  }
  return photograph;
}

// The views that remain, over geometry that was made of them alone, and those that do not.
struct LeftOutScene {
  std::shared_ptr<const RenderScene> scene;
  std::vector<LeftOutPhotograph> left_out;
};

LeftOutScene SceneOf(const LeftOutSet& set) {
  constexpr int kManyViews = 24, kEvery = 8, kEveryOfFew = 4;
  const int every = set.light_field.views.size() >= kManyViews ? kEvery : kEveryOfFew;
  const std::vector<int> left_out = EveryView(set.light_field, every, every / 2);
  SceneOptions options = set.options;
  const ProxyOptions geometry{.keep_maps = true};
  options.size_limit_px = geometry.size_px;
  options.leave_out = left_out;
  Progress progress("geometry of " + set.name);
  ProxyMesh made = BuildProxy(*LoadScene(set.light_field, options), geometry, &progress);
  auto all = LoadScene(set.light_field, set.options);
  const auto proxy =
      std::make_shared<SoftProxy>(all->subject, std::make_shared<TriangleMesh>(std::move(made.mesh)),
                                  SoftProxy::InMemory(std::move(made.maps)));
  if (!all->knows_exposures) all = WithLight(*all, FitLight(*WithProxy(*all, proxy)));
  LeftOutScene scene{WithProxy(*Without(*all, left_out), proxy), {}};
  for (const int v : left_out)
    scene.left_out.push_back(PhotographOf(all->views[static_cast<std::size_t>(v)]));
  return scene;
}

double MeanPsnr(const std::vector<LeftOutPhotograph>& photographs,
                const std::function<cv::Mat(const LeftOutPhotograph&)>& picture_of) {
  double sum = 0;
  for (const LeftOutPhotograph& one : photographs)
    sum += CompareImages(picture_of(one), one.bgr, one.valid).psnr_db;
  return sum / static_cast<double>(photographs.size());
}

cv::Mat DrawnOf(const Gaussians& gaussians, const LeftOutPhotograph& at) {
  cv::Mat bytes;
  DrawSplats(gaussians, at.camera, at.cam_from_world).srgb.convertTo(bytes, CV_8U, 255);
  return bytes;
}

constexpr char kByCount[] = "by how many Gaussians there are",
               kBySeconds[] = "by the time in which they are made",
               kBesideMesh[] = "beside the mesh (line: as good)";
const std::size_t kDefaultMost = SplatOptions{}.most;

void AddSet(const LeftOutSet& set, const std::vector<std::size_t>& counts, Table& table) {
  const LeftOutScene scene = SceneOf(set);
  const auto drawn_db = [&](const std::shared_ptr<const RenderScene>& drawn, const FieldOptions& field) {
    const auto renderer = MakeRenderer(drawn, {.field = field});
    return MeanPsnr(scene.left_out, [&](const LeftOutPhotograph& at) {
      return Srgb8FromLinear(renderer->Render(at.camera, at.cam_from_world).linear);
    });
  };
  const double soft_db = drawn_db(scene.scene, {.kind = FieldKind::kSoft});
  const auto mesh = std::make_shared<MeshProxy>(scene.scene->subject, scene.scene->proxy->Occluder());
  const double mesh_db =
      drawn_db(WithProxy(*scene.scene, mesh), {.kind = FieldKind::kSubdivision, .level = 1});
  std::string line =
      fmt::format("{}: {} views of {}x{}, {} left out, mesh {:.2f} dB, soft field {:.2f} dB", set.name,
                  scene.scene->views.size(), scene.left_out.front().camera.width,
                  scene.left_out.front().camera.height, scene.left_out.size(), mesh_db, soft_db);
  for (const std::size_t most : counts) {
    const double before_ms = ProcessCpuMs();
    const Splats splats = MakeSplats(*scene.scene, {.most = most});
    const double seconds = 1e-3 * (ProcessCpuMs() - before_ms);
    const double db =
        MeanPsnr(scene.left_out, [&](const LeftOutPhotograph& at) { return DrawnOf(splats.gaussians, at); });
    const auto count = static_cast<double>(splats.gaussians.size());
    const std::string name = fmt::format("{}k", most / 1000);
    if (counts.size() > 1) table.Add(kByCount, set.name, name, count, db, most == kDefaultMost);
    table.Add(kBySeconds, set.name, name, seconds, db, most == kDefaultMost);
    if (most == kDefaultMost) table.Add(kBesideMesh, set.name, "", mesh_db, db);
    line += fmt::format("; {} Gaussians {:.2f} dB in {:.0f} s of processor", splats.gaussians.size(), db,
                        seconds);
  }
  fmt::print("{}\n", line);
  std::fflush(stdout);
}

Chart MeasureSplats(const Effort& effort) {
  Table table;
  table.Panel(kByCount, Log("Gaussians"), MoreIsBetter({"PSNR [dB]"}), {.compared = false});
  table.Panel(kBySeconds, Log("processor time [s]"), MoreIsBetter({"PSNR [dB]"}), {.compared = false});
  table.Panel(kBesideMesh, {"mesh [dB]"}, MoreIsBetter({"Gaussians [dB]"}),
              {.compared = false, .joined = false, .diagonal = true});
  const ScratchFolder scratch;
  for (const char* name : {"Herz-Jesus-P8", "fountain-P11", "llff_fern", "temple_ring", "fox_half"}) {
    if (effort.quick) break;
    if (const auto set = FoundSet(name, scratch.path()))
      AddSet(*set, {kDefaultMost}, table);
    else
      fmt::print("{}: not among the test data\n", name);
  }
  for (const char* scene : {"studio", "gloss"})
    for (const unsigned seed : effort.Seeds(1)) {
      const std::string name = fmt::format("{}, seed {}", scene, seed);
      const ScanOptions scan{
          .uri = fmt::format("sim:{}?seed={}&look_away=0", scene, seed), .views = 24, .frames_between = 48};
      AddSet({name, SimulatedScan(scan, scratch / name)},
             effort.Of(std::vector<std::size_t>{60000}, {60000, 250000, kDefaultMost}), table);
    }
  return {.panels = table.panels()};
}

CHART(splats, MeasureSplats, "Gaussians without training: pictures of left-out views", R"(Every eighth view
  is left out (of fewer than 24 every fourth), of the depth maps, too. Means of the whole frame, at the full
  size of the photographs, over the same pixels in both; names say how many Gaussians there may be. Simulated
  scans of 24 views with the sensor's noise and exact poses. Herz-Jesus-P8 is the one set of photographs that
  constants were settled on; fountain-P11 and temple_ring decided between rules. Ringed: the default.)",
      true);

}  // namespace
}  // namespace ulf::test
