// Finds two views from which a map can start (relative_pose.h).
//
// The initializer keeps a reference frame and matches every further frame with it. When too few features
// match, the current frame becomes the reference. A camera that only turns never starts a map.
#pragma once

#include <optional>
#include <vector>

#include "core/geometry/camera_model.h"
#include "tracking/estimation/relative_pose.h"
#include "tracking/map/tracked_image.h"
#include "tracking/tracker/start_progress.h"

namespace ulf::tracking {

struct InitializerAttempt {
  StartProgress progress;  // what is missing; the next four are as in RelativePoseResult
  RelativePoseOutcome outcome = RelativePoseOutcome::kTooFewMatches;
  double direction_sigma_deg = 0;
  RelativePoseModel model = RelativePoseModel::kEssential;
  MotionEvidence evidence;
  double median_motion_px = 0;        // of the matched features since they were last seen
  std::optional<TwoViewStart> start;  // set for kFound alone
};

class Initializer {
 public:
  Initializer(const CameraModel& camera, unsigned seed) : camera_(camera), seed_(seed) {}
  InitializerAttempt Step(const TrackedImage& image);
  void Restart() { reference_.reset(); }  // makes the next frame the reference
  // Replaces the lens by another of the same image size, and restarts.
  void SetCamera(const CameraModel& camera) {
    camera_ = camera;
    Restart();
  }

 private:
  void SetReference(const TrackedImage& image);
  CameraModel camera_;
  unsigned seed_;
  std::optional<TrackedImage> reference_;
  std::vector<Eigen::Vector2d> expected_;  // by reference feature: where it was last seen
  std::vector<double> seen_s_;             // by reference feature: when it was last seen
  std::vector<Eigen::Vector2d> flow_;      // by reference feature: its first velocity in the image, px/s
};

}  // namespace ulf::tracking
