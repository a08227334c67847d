// Holds as values all that the display draws on the subject's sphere, which is all that a person who looks at
// it (also the simulated operator) can know of the map: the side that faces the camera, and the views on it.
//
// Directions are unit vectors from the sphere's centre in the camera's axes (x right, y down, z away from the
// camera); angles are radians; lengths are in units of the distance to the sphere's centre, since a picture
// has no scale.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "coverage/bound/coverage_map.h"
#include "coverage/bound/sphere_outline.h"
#include "coverage/session/capture_state.h"

namespace ulf::coverage {

struct ShownSphere {
  double radius = 0;              // share of the distance
  Eigen::Vector3d toward_camera;  // where the red dot is
  double least_cosine = 0;        // to the dot, of all that is shown: the limb
  CapFrame frame;                 // of the wireframe
  std::optional<Cap> cap;         // its outline

  // Painted cells: azimuths and elevations about `frame`. `nearer` is the colour: 0 where the view lies as
  // far away as the camera is, 1 where it is so much nearer that it just does not cover, -1 farther.
  struct Paint {
    double left = 0, right = 0, bottom = 0, top = 0;
    double nearer = 0;
  };
  std::vector<Paint> paint;
  struct View {
    Eigen::Vector3d direction;
    double rim = 0;  // radius of the circle around it; 0: none is drawn
  };
  std::vector<View> views;
  std::vector<Eigen::Vector3d> reopened, left_open;  // marks
  // The error that was measured in a direction.
  struct Error {
    Eigen::Vector3d direction;
    double db_above_goal = 0;  // below 0: the pictures are not good enough there
    render::ErrorCause cause = render::ErrorCause::kNone;
    bool marked = false;  // covered by a recorded view, and not good enough all the same
  };
  std::vector<Error> errors;
  struct Target {
    Eigen::Vector3d direction;  // of one that is hidden: where the way to it meets the limb
    double ring = 0;
    bool hidden = false;
  };
  std::optional<Target> target;  // the yellow arrow's

  // Returns none without a pose or a subject, or inside the sphere. `reach`: largest angle from the dot.
  static std::optional<ShownSphere> Of(const CaptureState& state, double reach = M_PI);

  // Returns the point of the sphere's surface in a direction, in the camera's frame.
  Eigen::Vector3d PointInCam(const Eigen::Vector3d& direction) const {
    return radius * direction - toward_camera;
  }
  bool Faces(const Eigen::Vector3d& direction) const { return direction.dot(toward_camera) > least_cosine; }
  // Returns the direction at `angle` from the dot towards `direction`.
  Eigen::Vector3d Along(const Eigen::Vector3d& direction, double angle) const;
  double AngleFromDot(const Eigen::Vector3d& direction) const;
};

// What the overlay shows of a capture's state; only the camera while there is no pose.
struct ShownPicture {
  CameraModel camera;
  std::optional<SafetyRectangle> rectangle;
  bool held = true;                               // the sphere is in the rectangle, which is then white
  std::optional<Eigen::Vector2d> way_to_subject;  // the red arrow's direction
  std::optional<ShownSphere> sphere;

  static ShownPicture Of(const CaptureState& state);
};

// Returns whether the subject's sphere is in the safety rectangle; none without a pose or a subject.
std::optional<bool> IsSubjectInRectangle(const CaptureState& state);

}  // namespace ulf::coverage
