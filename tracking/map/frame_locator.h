// Finds a frame's pose in the map. The tracker has one locator for its frames, the loop closer another.
//
// With a prediction it matches the points of the frame before, then the whole neighbourhood under the better
// pose, then, by their patches, points whose corners were not detected. Each step refines the pose. Without a
// prediction it ranks keyframes by descriptors, proposes a pose (P3P in a seeded sampler) and verifies it.
//
// Image points are pixels of the camera that the locator was made for. Poses are cam_from_world in the world
// of the named part of the map. Functions take the map's lock while they read the map, and return none if
// fewer than kMinLocatedMatches matches agree on a pose.
#pragma once

#include <optional>
#include <unordered_map>
#include <vector>

#include "core/base/stage_times.h"
#include "core/geometry/camera_model.h"
#include "tracking/map/frame_report.h"
#include "tracking/map/map.h"
#include "tracking/map/map_matching.h"
#include "tracking/map/pose_log_odds.h"
#include "tracking/map/relocalizer.h"

namespace ulf::tracking {

// A pose needs at least so many matches that agree. Guessed.
inline constexpr int kMinLocatedMatches = 12;

class FrameLocator {
 public:
  // `corners` is about the number of corners of a frame.
  FrameLocator(const CameraModel& camera, const SharedMap& shared, int corners);
  void SetCamera(const CameraModel& camera) { camera_ = camera; }  // another lens, the same image size

  // Follows a camera: starts with the points in `first` (those of the frame before: their ids and image
  // points), within `first_radius_px` of where the predicted pose projects them. Adds the times to `stages`.
  std::optional<FramePose> Locate(const TrackedImage& image, const Rigid3& predicted, int part,
                                  double first_radius_px,
                                  const std::unordered_map<int, Eigen::Vector2d>& first, StageTimes& stages);
  // Refines a pose that is good to `radius_px`, with the candidates that it has.
  std::optional<FramePose> Refine(const TrackedImage& image, FramePose frame_pose, double radius_px,
                                  StageTimes& stages) const;

  // Verifies a pose from elsewhere (fiducials) in the main part. Returns none if the map contradicts it.
  std::optional<FramePose> FindAt(const TrackedImage& image, const Rigid3& cam_from_world) const;
  // Finds the pose by the image alone, in any part of the map (relocalisation). Returns none if points that
  // are not repetitive do not support it (pose_log_odds.h).
  std::optional<FramePose> Find(const TrackedImage& image, const KeyframeIndex& index, unsigned seed) const;
  // Does the same in the main part of the map alone.
  std::optional<FramePose> FindInMainPart(const TrackedImage& image, const KeyframeIndex& index,
                                          unsigned seed) const;

  // Refines a pose that is off by up to 10 px (at 640 px of width), with the points that it should see.
  std::optional<FramePose> FindNear(const TrackedImage& image, const Rigid3& cam_from_world, int part) const;
  // Does the same with the candidates that the pose has.
  std::optional<FramePose> RefineTwice(const TrackedImage& image, FramePose frame_pose) const;

  // Fills a keyframe's features and observations: the detected corners, and one feature for each point that
  // was found by its patch alone. Omits corners next to those, which would make second copies.
  void Describe(const FeatureSet& detected, const FramePose& frame_pose, NewKeyframe& keyframe) const;

 private:
  std::optional<FramePose> FindAmong(const std::vector<KeyframeIndex::Ranked>& ranked,
                                     const TrackedImage& image, unsigned seed) const;
  std::optional<FramePose> FindBy(int keyframe, const TrackedImage& image, unsigned seed) const;
  void ExcludeOtherPlaces(const std::vector<KeyframeIndex::Ranked>& ranked, const FramePose& frame_pose,
                          ExcludedCandidates& left_out) const;
  CameraModel camera_;
  const SharedMap& shared_;
  int undetected_;  // number of patches that are tried where no corner was detected
  int sweep_ = 0;   // of GatherCandidatesNear()
};

}  // namespace ulf::tracking
