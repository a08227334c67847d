// A frame's pose against the map, from a prediction: the points of the frame before, then the whole
// neighbourhood under the better pose, then points whose corners were not detected, by their patches; each
// time the pose is refined.
#pragma once

#include <optional>
#include <unordered_map>
#include <vector>

#include "core/base/stage_times.h"
#include "core/geometry/camera_model.h"
#include "tracking/estimation/pose_log_odds.h"
#include "tracking/map/map_matching.h"
#include "tracking/map/mapper.h"
#include "tracking/map/relocalizer.h"

namespace ulf::tracking {

// What one frame's matching against the map came to.
struct FramePose {
  Rigid3 cam_from_world;
  Rigid3 picture_from_cam;  // of a rolling shutter (Track::cam_from_world)
  std::vector<Candidate> candidates;
  std::vector<PointMatch> matches;  // that support the pose
  std::vector<int> in_view;         // candidates that the pose should see
  std::vector<int> looked_for;      // those among them that matching had a chance to find
  double expected = 0;              // how many of those should have been found, by their record
  double center_sigma = 0;
};

// How far from where a pose would have them the points were found, in the middle; infinite of none.
double MedianShiftPx(const CameraModel& camera, const FramePose& located, const Rigid3& cam_from_world);

class FrameLocator {
 public:
  // `most_undetected`: how many patches may be tried without a detected corner, per frame.
  FrameLocator(const CameraModel& camera, const SharedMap& shared, int most_undetected)
      : camera_(camera), shared_(shared), most_undetected_(most_undetected) {}

  // Follows: begins with the points in `first` (by id: those of the frame before), within `first_radius_px`
  // of where the prediction has them.
  std::optional<FramePose> Locate(const TrackedImage& image, const Rigid3& predicted, double first_radius_px,
                                  const std::unordered_map<int, Eigen::Vector2d>& first, StageTimes& stages);
  // From candidates and a pose that is good to `radius_px`.
  std::optional<FramePose> Refine(const TrackedImage& image, FramePose located, double radius_px,
                                  StageTimes& stages) const;

  // Where what the frame shows of a given world says that it is; none where the map does not agree.
  std::optional<FramePose> FindAt(const TrackedImage& image, const Rigid3& cam_from_world) const;
  // From nothing but what the image looks like: by descriptors, P3P, and then the whole map under that pose.
  // None where what is found nowhere else does not speak for it (pose_log_odds.h).
  std::optional<FramePose> Find(const TrackedImage& image, const KeyframeIndex& index, unsigned seed) const;

  // The frame as a keyframe's features and observations: the detected corners, and one feature for each point
  // that its patch alone found. Detected corners next to those would become second copies of the same points:
  // left out.
  void Describe(const FeatureSet& detected, const FramePose& located, NewKeyframe& keyframe) const;

 private:
  std::optional<FramePose> FindBy(int keyframe, const TrackedImage& image, unsigned seed) const;
  std::optional<FramePose> RefineTwice(const TrackedImage& image, const Rigid3& cam_from_world) const;
  void ExcludeOtherPlaces(const std::vector<KeyframeIndex::Ranked>& ranked, const FramePose& located,
                          LeftOut& left_out) const;
  CameraModel camera_;
  const SharedMap& shared_;
  int most_undetected_;
  int sweep_ = 0;  // where the next look at the far rest of the map begins
};

}  // namespace ulf::tracking
