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
#include "tracking/map/map_matching.h"
#include "tracking/map/mapper.h"
#include "tracking/map/pose_log_odds.h"
#include "tracking/map/relocalizer.h"
#include "tracking/tracker/tracker_options.h"

namespace ulf::tracking {

// A frame's pose and the matches with the map that support it.
struct FramePose {
  Rigid3 cam_from_world;
  // With a rolling shutter: from the camera to the pose that explains the image best (Track::cam_from_world).
  Rigid3 picture_from_cam;
  Twist twist = Twist::Zero();  // and the camera's velocity while the rows were read
  std::vector<Candidate> candidates;
  std::vector<PointMatch> matches;  // that support the pose
  std::vector<int> in_view;         // candidates that the pose should see
  std::vector<int> looked_for;      // those of them that matching had a chance to find
  double expected = 0;              // how many of `looked_for` should be found, by their find rates
  double center_sigma = 0;          // one standard deviation of the camera's centre, world units

  const Candidate& CandidateOf(const PointMatch& match) const {
    return candidates[static_cast<std::size_t>(match.candidate)];
  }
};

// The matches that a refinement kept; it may have had more observations behind them.
std::vector<PointMatch> InliersOf(const std::vector<PointMatch>& matches, const PoseRefinement& refined);

// The median distance of the matches from where a pose projects their points; infinite without matches.
double MedianShiftPx(const CameraModel& camera, const FramePose& frame_pose, const Rigid3& cam_from_world);

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
