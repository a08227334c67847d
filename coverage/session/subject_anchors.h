// Moves the subject with corrections of the map. The subject is a sphere in the world; when the tracker
// corrects its map (a loop closes, an adjustment moves keyframes), the things in the sphere move with the
// points around them, and the sphere must follow.
//
// Each anchor is the sphere relative to one camera, anchored as the views' poses are
// (tracking/map/anchored.h), so that it follows both the keyframe and its unit of length. The sphere is at
// the anchors' mean.
//
// Another lens moves everything nearer or farther while the cameras stay about where they were. Then the
// sphere goes to where the anchors' cameras, under the new lens, see the pixel in which they saw its centre,
// and gets the radius that makes it as large as it was in these pictures.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/geometry/camera_model.h"
#include "core/light_field/light_field.h"
#include "tracking/tracker/pose_source.h"

namespace ulf::coverage {

class SubjectAnchors {
 public:
  void Clear() { anchors_.clear(); }
  bool empty() const { return anchors_.empty(); }
  // `track` needs a pose and an anchor of the same moment as `subject`; else nothing happens.
  void Add(const Subject& subject, const tracking::Track& track);
  // Returns whether a camera at this pose sees the subject from a direction at least this far, in radians,
  // from those of all anchors, as these were when they were added.
  bool StandsApart(const Subject& subject, const Rigid3& cam_from_world, double least_angle) const;
  // Returns the sphere in the tracker's present map; none without anchors.
  std::optional<Subject> Now(const tracking::PoseSource& poses) const;
  // Converts the anchors from the lens `before` to `now`, under which `poses` are already, and returns the
  // sphere. Returns none without anchors, or where these lenses do not see the sphere.
  std::optional<Subject> ReplaceLens(const CameraModel& now, const CameraModel& before,
                                     const tracking::PoseSource& poses);

 private:
  struct Anchor {
    tracking::Anchored camera;
    // Centre and radius in that camera's frame, in the unit of `camera`.
    Eigen::Vector3d center;
    double radius = 0;
    Eigen::Vector3d direction;  // of the camera from the subject, in the world of then; unit length
  };
  std::vector<Anchor> anchors_;
};

}  // namespace ulf::coverage
