// Defines what tracker and mapper keep of a frame's image, and the two frames that start a map.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <vector>

#include "core/geometry/rigid3.h"
#include "tracking/estimation/rolling_shutter.h"
#include "tracking/features/features.h"
#include "tracking/features/matching.h"
#include "tracking/map/fiducial_observation.h"

namespace ulf::tracking {

// Image points are pixels of the working size (tracker/working_size.h).
struct TrackedImage {
  double time_s = 0;
  std::shared_ptr<const Pyramid> pyramid;
  std::shared_ptr<const FeatureSet> features;
  // The same features where a rolling shutter saw them; null: the shutter is global.
  std::shared_ptr<const FeatureSet> detected = {};
  std::shared_ptr<const FiducialObservation> fiducials = {};  // null: the image shows none
};

// Two views whose relative pose and points were found from their matches alone (relative_pose.h). The world
// is the first view's camera; the translation has length 1.
struct TwoViewStart {
  TrackedImage first, second;
  Rigid3 second_from_first;
  std::vector<FeatureMatch> matches;    // those that gave a point
  std::vector<Eigen::Vector3d> points;  // by match
  // By match, its velocity in the image, px/s, after the first view and before the second; NaN: unknown.
  std::vector<Eigen::Vector2d> first_flow, second_flow;
  // The cameras' velocities that explain the flow (RowMotion::InitializeFrom()); none: unknown.
  std::optional<Twist> first_velocity, second_velocity;
};

}  // namespace ulf::tracking
