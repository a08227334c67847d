// The viewer's camera stands at a place and looks at a point, without roll. Movements are functions from a
// camera to a camera. Lengths are in world units of the light field, angles in radians.
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>

#include "core/geometry/angles.h"
#include "core/geometry/camera_model.h"
#include "core/geometry/rigid3.h"
#include "render/scene/scene.h"

namespace ulf::render {

struct ViewerCamera {
  Eigen::Vector3d eye_in_world = Eigen::Vector3d::UnitZ();
  Eigen::Vector3d target_in_world = Eigen::Vector3d::Zero();
  Eigen::Vector3d up_in_world = -Eigen::Vector3d::UnitY();  // unit
  CameraModel photograph;  // the lens: at zoom 1 a photograph of this camera just fills the window
  double zoom = 1;
  bool operator==(const ViewerCamera&) const = default;

  double Distance() const { return (eye_in_world - target_in_world).norm(); }
  Rigid3 CamFromWorld() const { return LookAt(eye_in_world, target_in_world, up_in_world); }
  CameraModel ModelFor(const cv::Size& screen) const;  // for a picture of this size
};

// Returns a camera in the middle of the viewpoints, at their median distance, or, if that is far from all of
// them (the middle of a ring), at the nearest viewpoint; it is aimed at the subject. Its up is the light
// field's, or that of the nearest photograph if the camera looks nearly along the light field's up.
ViewerCamera StartingCamera(const RenderScene& scene);

// Moves the camera round the target: to its own right, and upwards, not past the poles. Radians.
ViewerCamera Orbited(ViewerCamera camera, double right, double up);
// Moves the camera and its target to its right and upwards, by these multiples of the distance to the target.
ViewerCamera Panned(ViewerCamera camera, double right, double up);
// Moves the camera towards the target; divides the distance by `factor`.
ViewerCamera MovedIn(ViewerCamera camera, double factor);
ViewerCamera Zoomed(ViewerCamera camera, double factor);
// Returns the camera after `movements` more movements like that from `before` to `now`, within limits.
ViewerCamera Extrapolated(const ViewerCamera& before, ViewerCamera now, int movements);
// Moves the camera to the nearest recorded viewpoint, still aimed at the target.
ViewerCamera AtNearestView(ViewerCamera camera, const RenderScene& scene);

// The smallest angle between an orbiting camera and a pole, where up has no meaning. Guessed.
inline constexpr double kLeastPolarRad = Radians(2);
// Limits of ViewerCamera::zoom. Guessed.
inline constexpr double kLeastZoom = 0.1, kMostZoom = 30;

}  // namespace ulf::render
