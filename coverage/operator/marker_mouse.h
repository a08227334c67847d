// A marker as a mouse with six degrees of freedom (thesis, section 4): what the marker is before the camera,
// the subject is before the virtual camera. The subject's centre sits in the marker's middle; as the marker
// lies at first, the light field is seen from the mean of its viewpoints, upright, from their median
// distance; nearer is nearer. The picture is always aimed at the subject.
#pragma once

#include <optional>

#include "core/geometry/rigid3.h"
#include "render/scene/scene.h"

namespace ulf::coverage {

class MarkerMouse {
 public:
  // `middle`: of the marker, in its own frame.
  MarkerMouse(const render::RenderScene& scene, const Eigen::Vector3d& middle);

  // The virtual camera while the marker is there. The first pose sets the scale.
  Rigid3 CamFromWorld(const Rigid3& cam_from_marker);

 private:
  Rigid3 held_from_world_;  // x right, y down, z away from the viewpoints; origin at the subject's centre
  Eigen::Vector3d middle_;
  double distance_ = 1;  // the viewpoints' median from the subject
  std::optional<double> world_per_metre_;
};

}  // namespace ulf::coverage
