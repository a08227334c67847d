// Tracks a camera's rotation while its position is not known: before a map has started, and while it is lost.
//
// Features count as directions, that is as points at infinity. Keyframes have known rotations; a frame is
// matched with the keyframe that looks most nearly where the frame is expected to look, and turned until most
// directions fit. A shift of the camera looks like a turn by as much parallax as it makes, and such errors
// add up from keyframe to keyframe. Measured: swaying by 20 cm before walls 2.6 to 3.4 m away, rotations are
// off by 0.6 to 4 degrees when the map starts, by up to 7 before one flat wall, where it starts late
// (docs/measured/tracking.md, "A hand that turns on the spot").
#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <optional>
#include <vector>

#include "core/geometry/camera_model.h"
#include "tracking/features/features.h"

namespace ulf::tracking {

class TurnTracker {
 public:
  TurnTracker(const CameraModel& camera, unsigned seed) : camera_(camera), seed_(seed) {}
  // Replaces the lens of the following frames by another of the same image size; features keep their rays.
  void SetCamera(const CameraModel& camera) { camera_ = camera; }
  void Forget() { *this = TurnTracker(camera_, seed_); }
  // Starts from a frame whose rotation is known.
  void Begin(std::shared_ptr<const FeatureSet> features, const Eigen::Quaterniond& cam_from_world);
  bool HasBegun() const { return !keyframes_.empty(); }
  // Returns the rotation cam_from_world of the next frame; none if too few directions fit. A frame with
  // enough features begins with the identity.
  std::optional<Eigen::Quaterniond> Step(const std::shared_ptr<const FeatureSet>& features);

 private:
  struct TurnKeyframe {
    std::shared_ptr<const FeatureSet> features;
    Eigen::Quaterniond cam_from_world;
  };
  struct Fit {
    Eigen::Quaterniond cam_from_world;
    int directions = 0;  // that agree
  };
  std::optional<Fit> FitTo(const TurnKeyframe& keyframe, const FeatureSet& features,
                           const Eigen::Quaterniond& expected) const;

  CameraModel camera_;
  unsigned seed_;
  std::vector<TurnKeyframe> keyframes_;
  bool missed_ = false;  // in the last frame
  Eigen::Quaterniond last_ = Eigen::Quaterniond::Identity(), step_ = Eigen::Quaterniond::Identity();
};

}  // namespace ulf::tracking
