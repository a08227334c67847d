#include "render/viewer/viewer_camera.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "render/output/camera_path.h"

namespace ulf::render {

using Eigen::Vector3d;

namespace {

const SceneView& NearestView(const RenderScene& scene, const Vector3d& eye_in_world) {
  return *std::ranges::min_element(
      scene.views, {}, [&](const SceneView& view) { return (view.center_in_world - eye_in_world).norm(); });
}

Vector3d RightOf(const ViewerCamera& camera) {
  return camera.CamFromWorld().DirectionInSource(Vector3d::UnitX());
}

// Looks at a point that is as far before a view as the middle of the points reaches.
ViewerCamera CameraOfView(const SceneView& view, const RenderScene& scene) {
  ViewerCamera camera;
  camera.eye_in_world = view.center_in_world;
  camera.target_in_world = view.cam_from_world.Inverse() * Vector3d(0, 0, scene.subject.radius);
  camera.photograph = view.camera.WithoutDistortion();
  camera.up_in_world = scene.up_in_world.normalized();
  return camera;
}

}  // namespace

CameraModel ViewerCamera::ModelFor(const cv::Size& screen) const {
  const double fills =
      std::max(1.0 * screen.width / photograph.width, 1.0 * screen.height / photograph.height);
  return CameraModel::Pinhole(screen.width, screen.height, zoom * fills * photograph.MeanFocalPx());
}

ViewerCamera StartingCamera(const RenderScene& scene) {
  constexpr double kNearlyAlong = 0.95;  // cosine. Guessed.
  if (!scene.has_subject) return CameraOfView(scene.views[scene.views.size() / 2], scene);
  const Rigid3 middle = OrbitPath(scene, 1).cam_from_world.front();
  ViewerCamera camera;
  camera.eye_in_world = middle.OriginInSource();
  camera.target_in_world = scene.subject.center_in_world;
  const SceneView& nearest = NearestView(scene, camera.eye_in_world);
  // A camera in the middle of a ring is not among its views.
  constexpr double kFarOff = 0.35;  // radians from every view. Guessed.
  if (AngleBetween(camera.eye_in_world - camera.target_in_world,
                   nearest.center_in_world - camera.target_in_world) > kFarOff)
    camera.eye_in_world = nearest.center_in_world;
  camera.photograph = nearest.camera.WithoutDistortion();
  camera.up_in_world = scene.up_in_world.normalized();
  const Vector3d forward = (camera.target_in_world - camera.eye_in_world).normalized();
  if (std::abs(forward.dot(camera.up_in_world)) > kNearlyAlong)
    camera.up_in_world = nearest.cam_from_world.DirectionInSource(-Vector3d::UnitY());
  return camera;
}

ViewerCamera Orbited(ViewerCamera camera, double right, double up) {
  const Vector3d axis = camera.up_in_world;
  Vector3d arm = camera.eye_in_world - camera.target_in_world;
  const double polar = AngleBetween(arm, axis);
  const double wanted =
      std::clamp(polar - up, std::min(kLeastPolarRad, polar), std::max(M_PI - kLeastPolarRad, polar));
  // The camera's right is counter-clockwise about up, as seen from above.
  arm = Eigen::AngleAxisd(wanted - polar, RightOf(camera)) * arm;
  arm = Eigen::AngleAxisd(right, axis) * arm;
  camera.eye_in_world = camera.target_in_world + arm;
  return camera;
}

ViewerCamera Panned(ViewerCamera camera, double right, double up) {
  const Rigid3 cam_from_world = camera.CamFromWorld();
  const Vector3d step = camera.Distance() * (right * cam_from_world.DirectionInSource(Vector3d::UnitX()) -
                                             up * cam_from_world.DirectionInSource(Vector3d::UnitY()));
  camera.eye_in_world += step;
  camera.target_in_world += step;
  return camera;
}

ViewerCamera MovedIn(ViewerCamera camera, double factor) {
  camera.eye_in_world = camera.target_in_world + (camera.eye_in_world - camera.target_in_world) / factor;
  return camera;
}

ViewerCamera Zoomed(ViewerCamera camera, double factor) {
  camera.zoom = std::clamp(camera.zoom * factor, kLeastZoom, kMostZoom);
  return camera;
}

ViewerCamera Extrapolated(const ViewerCamera& before, ViewerCamera now, int movements) {
  constexpr double kMostTimes = 4, kMostTurn = 0.5;  // limits after a jump of the camera. Guessed.
  const Vector3d arm_before = before.eye_in_world - before.target_in_world;
  const Vector3d arm = now.eye_in_world - now.target_in_world;
  Vector3d turn = movements * (arm.normalized() - arm_before.normalized());
  if (turn.norm() > kMostTurn) turn *= kMostTurn / turn.norm();
  const double farther =
      std::clamp(std::pow(arm.norm() / arm_before.norm(), movements), 1 / kMostTimes, kMostTimes);
  now.target_in_world += movements * (now.target_in_world - before.target_in_world);
  now.eye_in_world = now.target_in_world + farther * arm.norm() * (arm.normalized() + turn).normalized();
  return now;
}

ViewerCamera AtNearestView(ViewerCamera camera, const RenderScene& scene) {
  camera.eye_in_world = NearestView(scene, camera.eye_in_world).center_in_world;
  return camera;
}

}  // namespace ulf::render
