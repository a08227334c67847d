// Where the subject is, when nobody says it: at the mean depth of the tracked points in the middle of the
// picture. (Thesis, section 3.1: "the system initializes its distance with the average depth of feature
// points".)
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/geometry/camera_model.h"
#include "core/light_field/light_field.h"
#include "tracking/sources/pose_source.h"

namespace ulf::coverage {

// The nearest and farthest quarter of the points may belong to what stands before or behind the subject and
// do not count. None with too few points.
std::optional<double> DepthNearCenter(const std::vector<tracking::VisiblePoint>& points,
                                      const CameraModel& camera);

// What is wrong with a subject for a camera that stands there, with the way out; empty: nothing.
std::string ProblemOf(const Subject& subject, const std::optional<Rigid3>& cam_from_world);

}  // namespace ulf::coverage
