// Draws a small sphere around the subject that shows where photographs were taken, the area that they cover,
// and where the camera is. It is seen from the middle of the viewpoints, or from slightly above if they stand
// all around. Its far side is drawn fainter; a camera on the far side is a ring.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "render/display/shapes.h"
#include "render/scene/scene.h"

namespace ulf::render {

class ViewpointGizmo {
 public:
  explicit ViewpointGizmo(const RenderScene& scene);

  struct Place {
    Eigen::Vector2d img;  // px of the picture
    bool front = true;    // on the visible side
  };
  // Returns the place of a direction from the subject's centre, in a picture of `size` x `size` px.
  Place PlaceOf(const Eigen::Vector3d& direction_in_world, double size) const;
  // Draws such a picture for a camera at this place.
  Overlay Draw(const Eigen::Vector3d& eye_in_world, double size) const;

  // Returns a warning for a camera at this place; empty if it is among the recorded viewpoints.
  std::string Warning(const Eigen::Vector3d& eye_in_world) const;

  // Returns about the distance between neighbouring viewpoints, world units: the median angle between
  // neighbours, at the distance of the farthest view. It is above zero.
  double Spacing() const;

 private:
  bool IsOutside(const Eigen::Vector3d& direction_in_world) const;
  Subject subject_;
  bool has_subject_;  // else `subject_` stands for the middle of the points
  ViewpointMesh mesh_;
  Eigen::Vector3d right_, up_, towards_;     // of the picture, in world axes
  std::vector<Eigen::Vector3d> directions_;  // of the views
  double spacing_rad_ = 0;                   // median angle between neighbours
  double nearest_ = 0, farthest_ = 0;        // distances of the views
};

}  // namespace ulf::render
