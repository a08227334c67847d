#include "tests/render/scenes/cap_scene.h"

#include <cmath>
#include <map>
#include <random>
#include <utility>

#include "acquisition/simulator/simulated_camera.h"
#include "render/output/camera_path.h"
#include "render/proxy/proxy.h"
#include "tests/render/scenes/held_photograph.h"
#include "tests/render/scenes/synthetic_views.h"
#include "tests/support/floors.h"

namespace ulf::test {

using Eigen::Vector3d;

namespace {

// As evenly as a hand leaves them: some have three neighbours, some ten.
std::vector<Vector3d> HandHeldViewpoints(int count) {
  const double spacing = std::sqrt(4 * M_PI / kWhole);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> off(-0.4 * spacing, 0.4 * spacing);
  std::vector<Vector3d> viewpoints = CapViewpoints(count, std::acos(1 - 2.0 * count / kWhole), 1.0, 0.05);
  for (Vector3d& viewpoint : viewpoints) {
    const double distance = viewpoint.norm();
    viewpoint = distance * (viewpoint + Vector3d(off(random), off(random), off(random))).normalized();
  }
  return viewpoints;
}

std::shared_ptr<const Photograph> OfStudio(const cv::Size& size) {
  static std::map<std::pair<int, int>, std::shared_ptr<const Photograph>> taken;
  std::shared_ptr<const Photograph>& photograph = taken[{size.width, size.height}];
  if (photograph) return photograph;
  SimulationOptions options;
  options.width = size.width;
  options.height = size.height;
  const SimulatedCamera studio(options);
  return photograph = test::HoldPhotograph(MakePyramid(studio.CleanSrgb(studio.hand().CamFromWorld(1))));
}

}  // namespace

std::shared_ptr<const RenderScene> CapScene(int count, const cv::Size& size) {
  auto scene = std::make_shared<RenderScene>();
  scene->subject = {Vector3d::Zero(), 0.3};
  scene->up_in_world = Vector3d::UnitY();
  for (const Vector3d& center : HandHeldViewpoints(count)) {
    SceneView& view = scene->views.emplace_back();
    view.id = static_cast<int>(scene->views.size());
    view.camera = CameraModel::Pinhole(size.width, size.height, size.width / 0.96);
    view.cam_from_world = LookAt(center, Vector3d::Zero(), Vector3d::UnitY());
    view.center_in_world = center;
    view.photograph = OfStudio(size);
  }
  scene->MakeMesh();
  scene->proxy = std::make_shared<PlaneProxy>(scene->subject);
  return scene;
}

}  // namespace ulf::test
