// A small sphere around the subject: where photographs were taken, the range that they cover, and where the
// camera is now. Seen from the middle of the viewpoints, and from a little above where they stand all around;
// what is on its far side is drawn fainter, the camera there as a ring.
#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "render/display/shapes.h"
#include "render/scene/scene.h"

namespace ulf::render {

class ViewpointGizmo {
 public:
  explicit ViewpointGizmo(const RenderScene& scene);

  struct Place {
    Eigen::Vector2d img;  // in the picture
    bool front = true;    // on the side that is seen
  };
  // Of a direction from the subject's centre, in a picture of `size` x `size`.
  Place Of(const Eigen::Vector3d& direction_in_world, double size) const;
  Overlay Draw(const Eigen::Vector3d& eye_in_world, double size) const;

  // What is to be said about standing there; empty where photographs stand all around.
  std::string Warning(const Eigen::Vector3d& eye_in_world) const;

  // How far a view's neighbour is, in the median; world units.
  double Spacing() const;

 private:
  bool IsOutside(const Eigen::Vector3d& direction_in_world) const;

  Subject subject_;
  ViewpointMesh mesh_;
  Eigen::Vector3d right_, up_, towards_;     // of the picture, in world axes
  std::vector<Eigen::Vector3d> directions_;  // of the views
  double spacing_rad_ = 0;                   // between neighbours, in the median
  double nearest_ = 0, farthest_ = 0;        // distances of the views
};

}  // namespace ulf::render
