// What clipped pixels do to pictures of views whose exposures differ, as light like any other and masked.
#include <cmath>

#include "acquisition/simulator/simulated_camera.h"
#include "core/image/clipped.h"
#include "render/gl/gl_renderer.h"
#include "render/proxy/points_proxy.h"
#include "tests/measure/runner.h"
#include "tests/measure/table.h"
#include "tests/render/scenes/held_photograph.h"
#include "tests/support/floors.h"

namespace ulf::test {
namespace {

constexpr double kShortS = 0.0025;  // full scale is twice the light of a white card

SimulatedCamera GlossCamera(unsigned seed) {
  SimulationOptions options;
  options.scene = "gloss";
  options.seed = seed;
  options.width = 360;
  options.height = 240;
  options.looks_away = false;
  return SimulatedCamera(options);
}

struct Exposed {
  cv::Mat light, clipped;
};

Exposed Photograph(const SimulatedCamera& camera, const Rigid3& pose, double exposure_s, std::uint64_t seed) {
  cv::Mat radiance = cv::Mat::zeros(camera.camera().height, camera.camera().width, CV_32FC4);
  camera.caster().AccumulateRows(pose, 1, 0, radiance.rows, radiance);
  const Image image =
      Expose(radiance,
             {.exposure_s = exposure_s, .gain = 1, .format = SensorFormat::kBayerRg12, .noise_seed = seed});
  return {LinearFloat(image), ClippedPixels(image)};
}

std::shared_ptr<RenderScene> Views(const SimulatedCamera& camera, int count, double stops, bool masks,
                                   double& clipped) {
  auto scene = std::make_shared<RenderScene>();
  scene->subject = camera.scene().subject();
  scene->up_in_world = Eigen::Vector3d::UnitZ();
  const double end_s = dynamic_cast<const Hand&>(camera.hand()).FirstPassEndS();
  double pixels = 0;
  for (int i = 0; i < count; ++i) {
    const bool is_long = i % 2 == 1;
    const double exposure_s = kShortS * (is_long ? std::exp2(stops) : 1);
    SceneView& view = scene->views.emplace_back();
    view.id = i + 1;
    view.camera = camera.camera();
    view.cam_from_world = camera.hand().CamFromWorld(end_s * (i + 0.5) / count);
    view.center_in_world = view.cam_from_world.OriginInSource();
    view.scale = static_cast<float>(kShortS / exposure_s);
    const Exposed photograph =
        Photograph(camera, view.cam_from_world, exposure_s, static_cast<std::uint64_t>(i));
    view.photograph = HoldPhotograph(
        MakeLinearPyramid(photograph.light, {}, masks && is_long ? photograph.clipped : cv::Mat()));
    if (is_long) clipped += photograph.clipped.empty() ? 0 : cv::countNonZero(photograph.clipped);
    if (is_long) pixels += static_cast<double>(photograph.light.total());
  }
  clipped /= pixels;
  scene->MakeMesh();
  scene->proxy = std::make_shared<PlaneProxy>(scene->subject);
  return scene;
}

std::vector<ScenePoint> PointsOf(const SimulatedCamera& camera, int count) {
  std::vector<ScenePoint> points;
  cv::RNG random(static_cast<std::uint64_t>(camera.options().seed) + 17);
  const double end_s = dynamic_cast<const Hand&>(camera.hand()).FirstPassEndS();
  while (static_cast<int>(points.size()) < count) {
    const Rigid3 world_from_cam = camera.hand().CamFromWorld(random.uniform(0.0, end_s)).Inverse();
    const auto ray = camera.camera().RayFromImg({random.uniform(0.0, 1.0) * camera.camera().width,
                                                 random.uniform(0.0, 1.0) * camera.camera().height});
    if (!ray) continue;
    const Eigen::Vector3d direction = (world_from_cam.rotation * *ray).normalized();
    ScenePoint point;
    point.position_in_world = world_from_cam.translation +
                              camera.scene().DepthAlong(world_from_cam.translation, direction) * direction;
    points.push_back(point);
  }
  return points;
}

struct Errors {
  double all = 0, bright = 0;  // root mean square in display levels of 255; bright: where long exposures clip
};

Errors ErrorsOf(const SimulatedCamera& camera, const std::shared_ptr<const RenderScene>& scene, int pictures,
                double stops) {
  const auto renderer = MakeRenderer(scene, {});
  const double end_s = dynamic_cast<const Hand&>(camera.hand()).FirstPassEndS();
  const CameraModel pinhole = camera.camera().WithoutDistortion();
  const SimulatedCamera& truth_camera = camera;
  double all = 0, bright = 0;
  long all_px = 0, bright_px = 0;
  for (int i = 0; i < pictures; ++i) {
    // Between the views.
    const Rigid3 pose = camera.hand().CamFromWorld(end_s * (0.1 + 0.8 * (i + 0.31) / pictures));
    const cv::Mat picture = renderer->Render(pinhole, pose).linear;
    const cv::Mat truth = truth_camera.caster().Radiance(pose) * (kShortS / kReferenceExposure_s);
    for (int y = 0; y < picture.rows; ++y)
      for (int x = 0; x < picture.cols; ++x) {
        // The truth is seen through the lens, the picture is not.
        const auto ray = camera.camera().ImgFromCam(
            Eigen::Vector3d((x + 0.5 - pinhole.cx) / pinhole.fx, (y + 0.5 - pinhole.cy) / pinhole.fy, 1));
        if (!ray || !camera.camera().Contains(*ray)) continue;
        const auto& should = truth.at<cv::Vec3f>(static_cast<int>(ray->y()), static_cast<int>(ray->x()));
        const cv::Vec3f& is = picture.at<cv::Vec3f>(y, x);
        double squares = 0;
        for (int c = 0; c < 3; ++c) {
          const auto level = [](float light) { return 255 * SrgbFromLinear(std::clamp(light, 0.0f, 1.0f)); };
          const double off = level(is[c]) - level(should[c]);
          squares += off * off / 3;
        }
        all += squares;
        ++all_px;
        if (std::max({should[0], should[1], should[2]}) * std::exp2(stops) < 1) continue;
        bright += squares;
        ++bright_px;
      }
  }
  return {std::sqrt(all / static_cast<double>(std::max(1L, all_px))),
          bright_px > 0 ? std::sqrt(bright / static_cast<double>(bright_px)) : std::nan("")};
}

constexpr char kAll[] = "whole pictures", kBright[] = "where the longer exposures clip",
               kShare[] = "what clips";

Chart MeasureClipped(const Effort& effort) {
  Table table;
  const ChartAxis cost{"longer exposures, stops"},
      levels{.label = "error [levels of 255, RMS]", .from_zero = true};
  table.Panel(kAll, cost, levels, {.compared = false});
  table.Panel(kBright, cost, levels, {.compared = false});
  table.Panel(kShare, cost, FromZero({"clipped pixels of the longer exposures [%]"}), {.compared = false});
  for (const bool masks : {false, true})
    for (const double stops : effort.Of(std::vector{0.0, 2.0}, {0.0, 0.5, 1.0, 1.5, 2.0, 3.0}))
      for (const unsigned seed : effort.Seeds(3)) {
        const SimulatedCamera camera = GlossCamera(seed);
        double clipped = 0;
        // As the program does: of one exposure nothing is masked.
        auto scene =
            Views(camera, effort.Of(16, 48), stops, masks && std::exp2(stops) > kMostExposureRatio, clipped);
        const Errors errors = ErrorsOf(
            camera, WithProxy(*scene, std::make_shared<PointsProxy>(scene->subject, PointsOf(camera, 3000))),
            effort.Of(2, 8), stops);
        const char* series = masks ? "masked" : "as light";
        const std::string name = fmt::format("{:g}", stops);
        table.Add(kAll, series, name, stops, errors.all, masks);
        table.Add(kBright, series, name, stops, errors.bright, masks);
        if (masks) table.Add(kShare, "of all pixels", name, stops, 100 * clipped);
      }
  return {.panels = table.panels()};
}

CHART(clipped, MeasureClipped, "Clipped pixels: as light like any other, and masked", R"(Polished vases that
  mirror lamps (scene gloss), 48 views along a hand's way, sensor noise, poses exact, 3,000 points; every
  other view is exposed longer by so many stops than those between, for which full scale is twice a white
  card. 8 pictures of each of three seeds from places between the views, against the light that is there, at
  the short exposure; subdivision weights. Bars: lowest to highest seed. Ringed: what is done.)");

}  // namespace
}  // namespace ulf::test
