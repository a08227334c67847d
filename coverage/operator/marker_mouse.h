// Uses a marker as a mouse with six degrees of freedom (thesis, section 4): the subject moves in front of the
// virtual camera as the marker moves in front of the real one. The marker's first pose corresponds to a view
// from the mean direction of the viewpoints, upright, at their median distance. The virtual camera always
// aims at the subject.
#pragma once

#include <optional>

#include "core/geometry/rigid3.h"
#include "render/scene/scene.h"

namespace ulf::coverage {

class MarkerMouse {
 public:
  // `middle`: the marker's middle in its own frame, metres. `scene` gives viewpoints, subject and up.
  MarkerMouse(const render::RenderScene& scene, const Eigen::Vector3d& middle);

  // Returns the virtual camera's pose for the marker's pose. The first pose sets the scale.
  Rigid3 CamFromWorld(const Rigid3& cam_from_marker);

 private:
  Rigid3 held_from_world_;  // x right, y down, z away from the viewpoints; origin at the subject's centre
  Eigen::Vector3d middle_;
  double distance_ = 1;  // the viewpoints' median from the subject
  std::optional<double> world_per_metre_;
};

}  // namespace ulf::coverage
