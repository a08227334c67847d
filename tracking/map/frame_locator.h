// Finds a frame's pose in the map.
//
// From a prediction: matches the points of the frame before, then the whole neighbourhood under the better
// pose, then, by their patches, points whose corners were not detected. Each step refines the pose. Without a
// prediction: ranks keyframes by descriptors, proposes a pose (P3P in a seeded sampler) and verifies it.
//
// Image points are pixels of the camera that the locator was made for, poses are in the map's world. Every
// function takes the map's lock while it reads the map.
#pragma once

#include <optional>
#include <unordered_map>
#include <vector>

#include "core/base/stage_times.h"
#include "core/geometry/camera_model.h"
#include "tracking/estimation/absolute_pose.h"
#include "tracking/map/frame_report.h"
#include "tracking/map/map.h"
#include "tracking/map/map_matching.h"
#include "tracking/map/pose_log_odds.h"
#include "tracking/map/relocalizer.h"

namespace ulf::tracking {

// Finding a frame in the map.
struct LocatorOptions {
  // For so many corners of a frame one patch is tried where no corner was detected. Guessed.
  int corners_per_patch = 5;
  int min_matches = 12;  // that agree; fewer are not even a hint of a pose. Guessed
  // Search radii: a pose that is good to a few pixels, and one that is not; descriptor distances for the
  // frame before's points, and for all. Guessed.
  double fine_radius_px = 4, wide_radius_px = 10;
  int first_max_distance = 80, max_distance = 70;
  RefinePoseOptions first_refinement = {.gate_sigmas = 3, .rounds = 2, .min_step = 1e-5};
  // Relocalization: keyframes that are ranked, and tried until one shows where the camera is; other places
  // that look alike and are asked whether the pose is ambiguous (a keyframe that shows less than this share
  // of the points is another place). Guessed.
  int ranked = 100, tried = 6, other_places = 5;
  double other_place_share = 1.0 / 3;
  // A detected corner this close (level pixels) to a point that its patch alone found is the same point.
  // Guessed.
  double shadow_px = 3;
};

class FrameLocator {
 public:
  // `corners`: how many a frame has, about.
  FrameLocator(const CameraModel& camera, const SharedMap& shared, int corners,
               const LocatorOptions& options = {})
      : camera_(camera),
        shared_(shared),
        options_(options),
        undetected_{.most = corners / options.corners_per_patch} {}
  void SetCamera(const CameraModel& camera) { camera_ = camera; }  // another lens, the same image size

  // Follows a camera in a part of the map: starts with the points in `first` (by id: those of the frame before), within
  // `first_radius_px` of where the prediction projects them.
  std::optional<FramePose> Locate(const TrackedImage& image, const Rigid3& predicted, int part,
                                  double first_radius_px,
                                  const std::unordered_map<int, Eigen::Vector2d>& first, StageTimes& stages);
  // Refines a pose that is good to `radius_px`, with the candidates it has.
  std::optional<FramePose> Refine(const TrackedImage& image, FramePose frame_pose, double radius_px,
                                  StageTimes& stages) const;

  // Verifies a pose in the main part that comes from elsewhere (fiducials); none where the map does not agree.
  std::optional<FramePose> FindAt(const TrackedImage& image, const Rigid3& cam_from_world) const;
  // Finds the pose by the image alone, in any part of the map. None where the points that look like nothing else do not support it
  // (pose_log_odds.h).
  std::optional<FramePose> Find(const TrackedImage& image, const KeyframeIndex& index, unsigned seed) const;
  // The same in the main part alone.
  std::optional<FramePose> FindInMainPart(const TrackedImage& image, const KeyframeIndex& index,
                                          unsigned seed) const;

  // From a pose that is off by pixels, with the candidates that it should see.
  std::optional<FramePose> FindNear(const TrackedImage& image, const Rigid3& cam_from_world, int part) const;
  // Refines within the wide search radius, then within the fine one. Takes a pose that is off by pixels.
  std::optional<FramePose> RefineTwice(const TrackedImage& image, FramePose frame_pose) const;

  // Fills a keyframe's features and observations: the detected corners, and one feature for each point that
  // its patch alone found. Omits detected corners next to those, which would make second copies of the
  // points.
  void Describe(const FeatureSet& detected, const FramePose& frame_pose, NewKeyframe& keyframe) const;

 private:
  std::optional<FramePose> FindAmong(const std::vector<KeyframeIndex::Ranked>& ranked,
                                     const TrackedImage& image, unsigned seed) const;
  std::optional<FramePose> FindBy(int keyframe, const TrackedImage& image, unsigned seed) const;
  void ExcludeOtherPlaces(const std::vector<KeyframeIndex::Ranked>& ranked, const FramePose& frame_pose,
                          LeftOut& left_out) const;
  CameraModel camera_;
  const SharedMap& shared_;
  LocatorOptions options_;
  UndetectedOptions undetected_;
  int sweep_ = 0;  // GatherCandidatesNear
};

}  // namespace ulf::tracking
