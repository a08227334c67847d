#include "tests/render/cap_scene.h"

#include <cmath>

#include "acquisition/simulator/simulated_camera.h"
#include "render/camera_path.h"
#include "render/proxy.h"
#include "tests/render/synthetic_views.h"

namespace ulf::test {

using Eigen::Vector3d;

std::shared_ptr<const RenderScene> CapScene(int count) {
  static const std::shared_ptr<const Photograph> photograph = [] {
    SimulationOptions options;
    options.width = 960;
    options.height = 640;
    const SimulatedCamera studio(options);
    return HoldPhotograph(MakePyramid(studio.CleanSrgb(studio.hand().CamFromWorld(1))));
  }();
  auto scene = std::make_shared<RenderScene>();
  scene->subject = {Vector3d::Zero(), 0.3};
  scene->up_in_world = Vector3d::UnitY();
  for (const Vector3d& center : CapViewpoints(count, std::acos(1 - 2.0 * count / kWhole), 1.0, 0.05)) {
    SceneView& view = scene->views.emplace_back();
    view.id = static_cast<int>(scene->views.size());
    view.camera = CameraModel::Pinhole(960, 640, 1000);
    view.cam_from_world = LookAt(center, Vector3d::Zero(), Vector3d::UnitY());
    view.center_in_world = center;
    view.photograph = photograph;
  }
  scene->MakeMesh();
  scene->proxy = std::make_shared<PlaneProxy>(scene->subject);
  return scene;
}

}  // namespace ulf::test
