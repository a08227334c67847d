// Projects the subject's sphere into a camera, and tests it against the safety rectangle (thesis, section
// 3.2).
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/geometry/camera_model.h"
#include "core/geometry/rigid3.h"
#include "core/light_field/light_field.h"

namespace ulf::coverage {

// Returns the image of the sphere's silhouette as a polygon, in pixels of the camera with its distortion; it
// may leave the frame. Returns none when the camera is inside the sphere or part of the silhouette has no
// image.
std::optional<std::vector<Eigen::Vector2d>> SphereOutline(const CameraModel& camera,
                                                          const Rigid3& cam_from_world,
                                                          const Subject& subject, int corners = 64);

// The rectangle in the middle of the image that has kRectangleShare of its width and height; pixels.
struct SafetyRectangle {
  Eigen::Vector2d low, high;  // the upper left and the lower right corner
  static SafetyRectangle Of(const CameraModel& camera);
  bool Holds(const std::vector<Eigen::Vector2d>& outline) const;
};

// Returns the sphere, in world coordinates, around the point of the optical axis at `depth` (world units)
// that appears `width_share` of the image's width wide, without distortion.
Subject SubjectOnAxis(const CameraModel& camera, const Rigid3& cam_from_world, double depth,
                      double width_share);

}  // namespace ulf::coverage
