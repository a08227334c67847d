// Holds as values all that the display draws on the subject's sphere, which is all that a person who looks at
// the display (or the simulated operator) can know of the map: the side that faces the camera, and the views
// on it.
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
  Eigen::Vector3d toward_camera;  // where the red dot of the present camera is
  double least_cosine = 0;        // of the angle to the dot, of all that is shown; the limb's if not limited
  CapFrame frame;                 // of the wireframe
  std::optional<Cap> cap;         // whose outline is drawn; none: none

  // Painted cells: azimuths and elevations about `frame`. `nearer` is the colour: 0 where the view lies as
  // far away as the camera is, 1 where it is so much nearer that it just does not cover, -1 farther.
  struct Paint {
    double left = 0, right = 0, bottom = 0, top = 0;
    double nearer = 0;
  };
  std::vector<Paint> paint;
  struct View {
    Eigen::Vector3d direction;
    double rim = 0;  // radius of the circle that encloses what it covers; 0: none is drawn
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
    Eigen::Vector3d direction;  // if it is hidden: where the way to it meets the limb
    double ring = 0;            // radius of the ring around it
    bool hidden = false;        // it is on the far side
  };
  std::optional<Target> target;  // where the yellow arrow points: Guidance::toward

  // Returns none without a pose or a subject, or inside the sphere. `reach`: what lies farther than this
  // angle from the dot is left out.
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

// What the overlay shows of a capture's state; while there is no pose, only `camera` is set.
struct ShownPicture {
  CameraModel camera;
  std::optional<SafetyRectangle> rectangle;
  bool held = true;  // the sphere is in the rectangle, which is then white
  // The red arrow's direction in the picture, unit length; none: the sphere's middle is in the rectangle.
  std::optional<Eigen::Vector2d> way_to_subject;
  std::optional<ShownSphere> sphere;

  static ShownPicture Of(const CaptureState& state);
};

// Returns whether the subject's sphere is in the safety rectangle; none without a pose or a subject.
std::optional<bool> IsSubjectInRectangle(const CaptureState& state);

}  // namespace ulf::coverage
