// The viewer's camera: it stands somewhere and looks at a point, without roll. All its movements are values:
// a camera in, a camera out. World frame and units of the light field, angles in radians.
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>

#include "core/geometry/camera_model.h"
#include "core/geometry/rigid3.h"
#include "render/scene/scene.h"

namespace ulf::render {

struct ViewerCamera {
  Eigen::Vector3d eye_in_world = Eigen::Vector3d::UnitZ();
  Eigen::Vector3d target_in_world = Eigen::Vector3d::Zero();
  Eigen::Vector3d up_in_world = -Eigen::Vector3d::UnitY();  // unit
  CameraModel photograph;  // whose lens it has: zoomed just so that a photograph fills the window
  double zoom = 1;         // times that
  bool operator==(const ViewerCamera&) const = default;

  double Distance() const { return (eye_in_world - target_in_world).norm(); }
  Rigid3 CamFromWorld() const { return LookAt(eye_in_world, target_in_world, up_in_world); }
  CameraModel For(const cv::Size& screen) const;
};

// In the middle of the viewpoints, at their median distance, aimed at the subject. Its up is the light
// field's, or that of the nearest photograph where the light field's is nearly the direction it looks in.
ViewerCamera StartingCamera(const RenderScene& scene);

// Round the target: `right` moves the camera to its own right, `up` upwards, not past the poles.
ViewerCamera Orbited(ViewerCamera camera, double right, double up);
// Sideways, with the target; in distances to it.
ViewerCamera Panned(ViewerCamera camera, double right, double up);
// Towards the target: the distance to it divided by `factor`.
ViewerCamera MovedIn(ViewerCamera camera, double factor);
ViewerCamera Zoomed(ViewerCamera camera, double factor);
// Where it will be so many movements like the last one further on.
ViewerCamera Ahead(const ViewerCamera& before, ViewerCamera now, int movements);
// To the recorded viewpoint that is next in angle and distance, still aimed at the target.
ViewerCamera AtNearestView(ViewerCamera camera, const RenderScene& scene);

// Nearer to the pole than this an orbit does not go.
inline constexpr double kLeastPolarRad = 2 * 3.14159265358979323846 / 180;
inline constexpr double kLeastZoom = 0.1, kMostZoom = 30;

}  // namespace ulf::render
