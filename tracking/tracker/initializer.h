// Waits for two views from which a map can start.
//
// A reference frame is kept and every further frame matched against it; when the matches thin out, the
// current frame becomes the reference. Refusals are values with a reason: turning on the spot never starts a
// map.
#pragma once

#include <optional>
#include <vector>

#include "core/geometry/camera_model.h"
#include "tracking/estimation/relative_pose.h"
#include "tracking/estimation/rolling_shutter.h"
#include "tracking/features/matching.h"
#include "tracking/map/map_matching.h"
#include "tracking/tracker/start_progress.h"

namespace ulf::tracking {

struct TwoViewStart {
  TrackedImage first, second;
  Rigid3 second_from_first;
  std::vector<FeatureMatch> matches;    // those that gave a point
  std::vector<Eigen::Vector3d> points;  // in the first view, by match
  // How the matches moved in the image, px/s: after the first view and before the second; NaN: unknown.
  std::vector<Eigen::Vector2d> first_flow, second_flow;
  // The cameras' velocities that they show.
  std::optional<Twist> first_velocity, second_velocity;
};

struct InitializerAttempt {
  StartProgress progress;
  RelativePoseOutcome outcome = RelativePoseOutcome::kTooFewMatches;
  double direction_sigma_deg = 0;
  RelativePoseModel model = RelativePoseModel::kEssential;
  MotionEvidence evidence;
  double median_motion_px = 0;  // since the frame before
  std::optional<TwoViewStart> start;
};

class Initializer {
 public:
  Initializer(const CameraModel& camera, double min_parallax_deg, unsigned seed);
  InitializerAttempt Step(const TrackedImage& image);
  void Restart() { reference_.reset(); }

 private:
  void SetReference(const TrackedImage& image);
  CameraModel camera_;
  double min_parallax_deg_;
  unsigned seed_;
  std::optional<TrackedImage> reference_;
  std::vector<Eigen::Vector2d> expected_;  // by reference feature: where it was last seen
  std::vector<double> seen_s_;             // and when
  std::vector<Eigen::Vector2d> flow_;      // and how it moved at first
};

}  // namespace ulf::tracking
