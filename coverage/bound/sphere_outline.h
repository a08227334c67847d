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

// Returns the silhouette's image as a polygon, with the camera's distortion. Returns none when the camera is
// inside the sphere or part of the silhouette has no image.
std::optional<std::vector<Eigen::Vector2d>> SphereOutline(const CameraModel& camera,
                                                          const Rigid3& cam_from_world,
                                                          const Subject& subject, int corners = 64);

// The middle of the image, kRectangleShare of its width and height.
struct SafetyRectangle {
  Eigen::Vector2d low, high;
  static SafetyRectangle Of(const CameraModel& camera);
  bool Holds(const std::vector<Eigen::Vector2d>& outline) const;
};

// Returns the sphere whose image is `width_share` of the image's width, around a point `depth` along the
// optical axis.
Subject SubjectOnAxis(const CameraModel& camera, const Rigid3& cam_from_world, double depth,
                      double width_share);

}  // namespace ulf::coverage
