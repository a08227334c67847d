// What refining works on: the recorded views, and points with all places where they are seen. Values only.
//
// Image quantities are pixels of the working resolution (the view's own, or reduced where it is larger than
// features need), pixel centres at integer + 0.5. Poses are cam_from_world in the units that the views came
// in.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <functional>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "core/geometry/camera_model.h"
#include "core/geometry/rigid3.h"
#include "core/image/image.h"
#include "tracking/estimation/bundle_adjustment.h"
#include "tracking/features/features.h"

namespace ulf::tracking {

struct RefineView {
  std::string name;
  int lens = 0;  // index into RefineScene::lenses
  Rigid3 start;  // as it came in
  Rigid3 cam_from_world;
  bool registered = true;
  std::string why;  // it is not
  FeatureSet features;
  std::vector<std::array<std::uint8_t, 3>> feature_rgb;
  cv::Mat gray;
};

struct TrackObservation {
  int view = 0;
  int feature = -1;  // -1: found by its patch alone
  Eigen::Vector2d img = Eigen::Vector2d::Zero();
  double sigma_px = 1;
};

struct SceneTrack {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  std::vector<TrackObservation> observations;  // at most one a view, in order of view
  std::array<std::uint8_t, 3> rgb{128, 128, 128};
};

struct RefineScene {
  std::vector<CameraModel> lenses;  // of the working resolution
  std::vector<RefineView> views;
  std::vector<SceneTrack> tracks;

  const CameraModel& LensOf(const RefineView& view) const {
    return lenses[static_cast<std::size_t>(view.lens)];
  }
  const RefineView& view(int i) const { return views[static_cast<std::size_t>(i)]; }
};

// A parallel loop over 0 to count - 1, in as many threads as OpenCV uses. Whatever `work` does must depend on
// its number alone, or the result would depend on the threads.
void ForAll(int count, const std::function<void(int)>& work);

// Reads every view, reduces it to at most `max_side_px`, and describes about `features` corners of it. A view
// that cannot be read is not registered any more and says why. `done` is called with how many are.
struct ViewReading {
  std::function<Image(int view)> read;  // throws Error
  int features = 1500;
  std::function<void(int done)> done;
};
void ReadViews(const ViewReading& reading, RefineScene& scene);

// Distance of an observation from where its point should appear, px; infinite where it does not.
double ReprojectionErrorPx(const RefineScene& scene, const SceneTrack& track, const TrackObservation& seen);

// The registered views and all tracks as an adjustment takes them, and back: observations that it calls
// outliers go, tracks with fewer than `min_views` observations with them.
BundleProblem ToBundle(const RefineScene& scene);
void FromBundle(const BundleProblem& problem, int min_views, RefineScene& scene);

// Drops points most of whose observations are off by several times what is usual. A corner on an outline,
// where a round thing turns away or one edge passes before another, is at no place in the world: it slides as
// the camera moves, in neighbouring views by the same, and bends their poses, though single observations fit.
void DropSliding(RefineScene& scene);

// Views that share points, directly or through others: a number for each view, -1 for those without points.
struct ViewGroups {
  std::vector<int> group;
  int count = 0;
};
ViewGroups GroupViews(const RefineScene& scene);

// Moves each group of views with its points by the similarity that brings the views back nearest to where
// they started: nothing in pictures holds position, orientation and scale. False where the views do not
// determine one.
bool AlignToStart(RefineScene& scene);

}  // namespace ulf::tracking
