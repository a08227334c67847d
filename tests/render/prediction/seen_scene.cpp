#include "tests/render/prediction/seen_scene.h"

#include <Eigen/Geometry>
#include <random>

#include "core/geometry/angles.h"
#include "core/geometry/pinhole.h"
#include "render/stereo/mesh_of_maps.h"

namespace ulf::test {
namespace {

using Eigen::Vector3d;

constexpr int kSmallPx = 320;

SimulationOptions OptionsOf(const std::string& name, int drawn_px) {
  SimulationOptions options;
  options.scene = name;
  options.width = drawn_px;
  options.height = drawn_px * 3 / 4;
  return options;
}

}  // namespace

SeenScene::SeenScene(const std::string& name, double spacing, int drawn_px)
    : camera_(OptionsOf(name, drawn_px)) {
  const double most_azimuth = Radians(15), most_elevation = Radians(10);
  std::vector<ViewDepth> maps;
  unsigned seed = 0;
  for (double elevation = -most_elevation; elevation < most_elevation + 1e-6; elevation += spacing)
    for (double azimuth = -most_azimuth; azimuth < most_azimuth + 1e-6; azimuth += spacing) {
      const Rigid3 pose = PoseFrom(azimuth, elevation);
      views_.push_back(Look(pose, ++seed));
      const StereoView& view = views_.back();
      const RayCaster caster(Scene::Named(name), view.camera);
      ViewDepth map{view, caster.RayLength(pose), 0.01};
      for (int y = 0; y < map.depth.rows; ++y)
        for (int x = 0; x < map.depth.cols; ++x) {
          const Vector3d ray = PinholeRay(view.camera, x, y);
          map.depth.at<float>(y, x) *= static_cast<float>(ray.z() / ray.norm());
        }
      maps.push_back(map);
    }
  mesh_ = std::make_shared<const TriangleMesh>(
      MeshOfMaps(std::move(maps), subject(), {.most_triangles = 60000}).mesh);
}

Rigid3 SeenScene::PoseFrom(double azimuth, double elevation) const {
  const Scene& scene = camera_.scene();
  const Vector3d side = scene.UpInWorld().cross(scene.FirstDirection()).normalized();
  const Vector3d direction = Eigen::AngleAxisd(azimuth, scene.UpInWorld()) *
                             (Eigen::AngleAxisd(-elevation, side) * scene.FirstDirection());
  return LookAt(scene.subject().center_in_world + scene.FirstDistance() * direction,
                scene.subject().center_in_world, scene.UpInWorld());
}

StereoView SeenScene::Look(const Rigid3& cam_from_world, unsigned seed, double sway) const {
  const Scene& scene = camera_.scene();
  const double angle = scene.sway() ? sway * scene.sway()->amplitude : 0;
  cv::Mat linear = camera_.caster().Radiance(cam_from_world, angle) * camera_.LightScale();
  StereoViewMaker maker(kSmallPx);
  StereoView view = maker.Make(Srgb8FromLinear(linear), camera_.camera(), cam_from_world);
  std::mt19937 random(seed);
  std::normal_distribution<float> noise(0, 1.5f);
  for (int y = 0; y < view.grey.rows; ++y)
    for (int x = 0; x < view.grey.cols; ++x) view.grey.at<float>(y, x) += noise(random);
  return view;
}

FramePredictor SeenScene::Predictor() const {
  FramePredictor predictor;
  predictor.SetGeometry(subject(), mesh_);
  for (std::size_t i = 0; i < views_.size(); ++i) predictor.AddView(static_cast<int>(i), views_[i]);
  return predictor;
}

}  // namespace ulf::test
