#include "tests/charts/studio_views.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "acquisition/simulator/simulated_camera.h"
#include "core/base/quantile.h"
#include "coverage/bound/coverage_map.h"
#include "coverage/bound/criterion.h"
#include "render/photographs/photograph.h"
#include "render/quality/evaluate.h"
#include "tests/charts/temporal/temporal_error.h"
#include "tests/render/scenes/held_photograph.h"
#include "tests/support/floors.h"

namespace ulf::test {
namespace {

using Eigen::Vector3d;

constexpr int kCoverageWidth = 640;
const Cap kCap = Cap::FromDegrees({60, 40});

SimulationOptions Simulated(const StudioOptions& options) {
  SimulationOptions simulated;
  simulated.seed = options.seed;
  simulated.width = options.width;
  simulated.height = options.height;
  simulated.looks_away = false;
  return simulated;
}

// How far apart rows may lie.
double RowSpacing(const SimulatedCamera& studio, double threshold_px) {
  const Subject& subject = studio.scene().subject();
  const double focal_px = studio.camera().fx * kCoverageWidth / studio.camera().width;
  const double distance = (studio.hand().CamFromWorld(0).OriginInSource() - subject.center_in_world).norm();
  return std::sqrt(3.0) * DiscRadius({focal_px, distance, subject.radius, threshold_px}).value();
}

SceneView Photographed(const SimulatedCamera& studio, const Rigid3& cam_from_world, int id) {
  SceneView view;
  view.id = id;
  view.camera = studio.camera();
  view.cam_from_world = cam_from_world;
  view.center_in_world = cam_from_world.OriginInSource();
  view.photograph = test::HoldPhotograph(MakePyramid(studio.CleanSrgb(cam_from_world)));
  return view;
}

// Inside what was recorded.
Hand OtherHand(const SimulatedCamera& studio, std::uint64_t seed) {
  HandOptions other = dynamic_cast<const Hand&>(studio.hand()).options();
  other.seed = seed + 1000;
  other.cap_azimuth *= 0.8;
  other.cap_elevation *= 0.8;
  other.margin = 0;
  return Hand(other);
}

}  // namespace

std::shared_ptr<const RenderScene> StudioScene(const StudioOptions& options) {
  SimulationOptions simulated = Simulated(options);
  constexpr double kMostSpacing = 19 * M_PI / 180;  // that the simulator lets itself be told
  simulated.row_spacing =
      std::min(kMostSpacing, RowSpacing(SimulatedCamera(simulated), options.threshold_px));
  const SimulatedCamera studio(simulated);
  auto scene = std::make_shared<RenderScene>();
  scene->subject = studio.scene().subject();
  scene->up_in_world = Vector3d::UnitZ();
  CoverageMap map(scene->subject, {kCap, Vector3d::UnitZ(), options.threshold_px});
  constexpr double kStep_s = 1.0 / 60, kLongest_s = 1800;
  for (double time_s = 0; time_s < kLongest_s && map.CoveredShare() < 0.95; time_s += kStep_s) {
    const Rigid3 pose = studio.hand().CamFromWorld(time_s);
    const CriterionView candidate = CriterionView::From(studio.camera(), pose, kCoverageWidth);
    if (map.Covers(candidate)) continue;
    map.Add(candidate);
    scene->views.push_back(Photographed(studio, pose, static_cast<int>(scene->views.size()) + 1));
  }
  scene->MakeMesh();
  scene->proxy = std::make_shared<PlaneProxy>(scene->subject);
  return scene;
}

std::vector<SceneView> StudioTruth(const StudioOptions& options, int count) {
  const SimulatedCamera studio(Simulated(options));
  const Hand hand = OtherHand(studio, options.seed);
  std::vector<SceneView> truth;
  for (int i = 0; i < count; ++i)
    truth.push_back(Photographed(
        studio, hand.CamFromWorld(hand.FirstPassEndS() * (0.1 + 0.9 * (i + 0.5) / count)), i + 1));
  return truth;
}

std::vector<TruePicture> StudioPath(const StudioOptions& options, int count) {
  const SimulatedCamera studio(Simulated(options));
  const Hand hand = OtherHand(studio, options.seed);
  std::vector<TruePicture> path;
  for (int i = 0; i < count; ++i) {
    const Rigid3 pose = hand.CamFromWorld(0.4 * hand.FirstPassEndS() + i / 30.0);
    const SceneView view = Photographed(studio, pose, i + 1);
    TruePicture picture{view.camera.WithoutDistortion(), pose, {}};
    Undistort(view).srgb8.convertTo(picture.levels, CV_32F);
    path.push_back(picture);
  }
  return path;
}

std::vector<ScenePoint> StudioPoints(const StudioOptions& options, int count) {
  const SimulatedCamera studio(Simulated(options));
  std::mt19937 random(static_cast<unsigned>(options.seed));
  std::uniform_real_distribution<double> unit(0, 1);
  std::normal_distribution<double> relative_error(0, 0.002);
  constexpr int kPlaces = 12;
  std::vector<ScenePoint> points;
  for (int place = 0; place < kPlaces; ++place) {
    const Rigid3 pose = studio.hand().CamFromWorld(60.0 * (place + 0.5) / kPlaces);
    const cv::Mat lengths = studio.caster().RayLength(pose);
    const int from_here = count * (place + 1) / kPlaces - count * place / kPlaces;
    for (int i = 0; i < from_here; ++i) {
      const int x = static_cast<int>(unit(random) * lengths.cols),
                y = static_cast<int>(unit(random) * lengths.rows);
      const auto ray = studio.camera().RayFromImg({x + 0.5, y + 0.5});
      const double length = lengths.at<float>(y, x);
      if (!ray || !std::isfinite(length) || length <= 0) continue;
      points.push_back({pose.Inverse() * (length * (1 + relative_error(random)) * ray->normalized())});
    }
  }
  return points;
}

RenderedQuality MeasureRendering(Renderer& renderer, const std::vector<SceneView>& truth) {
  RenderedQuality quality;
  std::vector<double> cpu_ms;
  for (const SceneView& view : truth) {
    const CameraModel camera = view.camera.WithoutDistortion();
    const UndistortedPhotograph photograph = Undistort(view);
    const Rendering first = renderer.Render(camera, view.cam_from_world);
    const double before = ProcessCpuMs();
    renderer.Render(camera, view.cam_from_world);
    cpu_ms.push_back(ProcessCpuMs() - before);
    const cv::Mat srgb8 = Srgb8FromLinear(first.linear);
    const cv::Mat disc = SubjectDisc(camera, view.cam_from_world, renderer.scene().subject);
    const double share = 1.0 / static_cast<double>(truth.size());
    const Quality frame = CompareImages(srgb8, photograph.srgb8, photograph.valid);
    quality.psnr_db += share * frame.psnr_db;
    quality.ssim += share * frame.ssim;
    quality.psnr_disc_db += share * CompareImages(srgb8, photograph.srgb8, photograph.valid & disc).psnr_db;
  }
  quality.cpu_ms = Median(cpu_ms);
  return quality;
}

double TemporalErrorAlong(Renderer& renderer, const std::vector<TruePicture>& path) {
  TemporalError error;
  for (const TruePicture& truth : path) {
    const Rendering picture = renderer.Render(truth.camera, truth.cam_from_world);
    error.Add(DisplayLevels(picture.linear), truth.levels,
              SubjectDisc(truth.camera, truth.cam_from_world, renderer.scene().subject));
  }
  return error.FrameRms();
}

}  // namespace ulf::test
