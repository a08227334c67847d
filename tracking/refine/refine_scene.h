// Holds the values that refining works on: views, and points with all observations.
//
// Image quantities are pixels of the working resolution (the view's own, or reduced if it is larger than
// features need), pixel centres at integer + 0.5. Poses are cam_from_world in the input's units.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/base/at.h"
#include "core/geometry/camera_model.h"
#include "core/geometry/rigid3.h"
#include "tracking/estimation/bundle_adjustment.h"
#include "tracking/features/features.h"

namespace ulf::tracking {

struct RefineView {
  std::string name;
  int lens = 0;  // index into RefineScene::lenses
  Rigid3 start;  // the input's pose
  bool is_recorded = true;
  Rigid3 cam_from_world;
  std::optional<Rigid3> middle_row_from_picture;  // as in RefinedView
  bool registered = true;                         // takes part
  std::string why;                                // the view is not registered
  FeatureSet features;
  std::vector<std::array<std::uint8_t, 3>> feature_rgb;
  cv::Mat gray;
};

// The place where a view shows a point.
struct TrackObservation {
  int view = 0;
  int feature = -1;  // index into the view's features; -1: the patch alone was found
  Eigen::Vector2d img = Eigen::Vector2d::Zero();
  double sigma_px = 1;
};

// A point, and all places where views show it.
struct SceneTrack {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  std::vector<TrackObservation> observations;  // at most one a view, by ascending view
  std::array<std::uint8_t, 3> rgb{128, 128, 128};
};

struct RefineScene {
  std::vector<CameraModel> lenses;  // of the working resolution
  std::vector<RefineView> views;
  std::vector<SceneTrack> tracks;

  const CameraModel& LensOf(const RefineView& view) const { return lenses[At(view.lens)]; }
  const RefineView& view(int i) const { return views[At(i)]; }
  int Registered() const;  // number of registered views
  // Returns how many views a track needs: two may agree by chance.
  int MinViews() const { return Registered() > 3 ? 3 : 2; }
  // Returns the indices of the tracks, those with most observations first.
  std::vector<int> LongestFirst() const;
  // Drops tracks with fewer than `min_views` observations.
  void DropShortTracks(int min_views);
};

// Returns how many pixels of the given images one pixel of the working resolution is wide.
double GivenByWorking(const CameraModel& given, const CameraModel& working);

// Returns the number of points that each view shows.
std::vector<int> PointsByView(const RefineScene& scene);

// Returns an observation's distance from its point's projection, px; infinite if the point does not project.
double ReprojectionErrorPx(const RefineScene& scene, const SceneTrack& track, const TrackObservation& seen);

// Convert views and tracks to a bundle adjustment's problem, in which one view of each group is fixed, and
// back. FromBundle() drops outliers, and tracks with fewer than `min_views` observations.
BundleProblem ToBundle(const RefineScene& scene);
void FromBundle(const BundleProblem& problem, int min_views, RefineScene& scene);

// Drops points whose median error is more than `most_times_usual` (guessed) times the median of all. A corner
// on an outline, where a round thing turns away or one edge passes before another, has no fixed place in the
// world: it slides as the camera moves, by the same amount in neighbouring views, and bends their poses
// although single observations fit.
void DropSlidingPoints(RefineScene& scene, double most_times_usual = 3);

// The groups of views that share points, directly or through other views.
struct ViewGroups {
  std::vector<int> group;  // by view; -1: it has no points
  int count = 0;
};
ViewGroups GroupViews(const RefineScene& scene);

// Marks views of groups without a recorded view as not registered, and drops their points, because nothing
// determines where such a group lies.
void DropGroupsWithoutRecordedViews(RefineScene& scene);

// Moves each group of views with its points by the similarity that brings its recorded views (all, if one
// alone is recorded) nearest to their start poses, because images leave position, orientation and scale open.
// Returns false if the views do not determine a similarity, or there is no group.
bool AlignToStart(RefineScene& scene);

}  // namespace ulf::tracking
