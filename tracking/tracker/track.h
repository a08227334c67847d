// Defines a pose source's result for one frame (pose_source.h), and messages about it.
//
// Poses are cam_from_world (x right, y down, z forward). The world and its unit are those of the source
// (docs/tracking.md). Image quantities are pixels of the images as they come.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/base/stage_times.h"
#include "core/frames/frame.h"
#include "core/geometry/rigid3.h"
#include "tracking/estimation/rolling_shutter.h"
#include "tracking/map/anchored.h"
#include "tracking/tracker/start_progress.h"

namespace ulf::tracking {

enum class TrackState {
  kInitializing,  // there is no map or pose yet
  kTracking,
  kLost,
  // The camera is tracked in a part of the map whose place in the main part's world is not known (yet). There
  // is no pose, but an anchor, which tells the pose as soon as the parts are joined.
  kApart
};

struct Track {
  TrackState state = TrackState::kInitializing;
  bool skipped = false;  // the frame was incomplete or empty: nothing was tried, the state stays
  // The map (or part of the map) in whose world the pose is. A map that is lost within its first frames is
  // discarded for another, and a part of the map that was tracked for longer takes the place of the main
  // part, unless views are recorded in that.
  int map_id = 0;
  bool relocalized = false;  // the camera was lost, and this frame found it again
  // The pose; none unless kTracking. Under a rolling shutter every row has a pose of its own: this is the one
  // pose that explains the image best as it is, because users of the image (renderer, coverage, other
  // programs) know no rows.
  std::optional<Rigid3> cam_from_world;
  // The same pose for PoseSource::PoseOf(): set whenever cam_from_world is, and while kApart.
  std::optional<Anchored> anchor;
  // Without a pose, the camera's rotation cam_from_world, if it is known although the position is not. The
  // world is that of the last pose or, before a map has started, the first frame's camera.
  std::optional<Eigen::Quaterniond> turn;
  // The camera's own pose when the middle row was read, relative to cam_from_world. It is set if a rolling
  // shutter is compensated; else the two are the same.
  std::optional<Rigid3> middle_row_from_picture;
  // The velocity while the rows were read, in the middle row's frame; set with middle_row_from_picture.
  std::optional<Twist> twist;
  // From 0 to 1: one half if PictureSigma() and lens_error_share together make a hundredth of `distance`.
  double quality = 0;
  int matched_points = 0;       // map points that support the pose
  std::optional<int> features;  // corners detected in the image; none: the source detects none
  // Predicted standard deviation of the camera's centre, world units, from matches and the map's error.
  std::optional<double> center_sigma;
  // How far the centre is from those of a rolling shutter's rows, world units.
  double rows_sigma = 0;
  double distance = 0;  // median distance of the points that support the pose, world units; 0: unknown
  // Returns center_sigma and rows_sigma together; none if center_sigma is none.
  std::optional<double> PictureSigma() const;
  std::optional<StartProgress> start;  // while initializing, and for the frame that started the map
  double sharpness = 1;                // fine detail over the recent frames' median: well below 1 is blurred
  double speed_px = 0;      // median motion of the tracked points since the frame before; 0: unknown
  bool keyframe = false;    // the mapper took this frame as a keyframe
  bool wrong_lens = false;  // the map contradicts the given lens: TrackerStatistics::calibration says how
  // The share of the distance by which the wrong lens displaces poses. Only `quality` counts it: a view under
  // a wrong lens is worth recording, because `ulf refine` finds the lens.
  double lens_error_share = 0;
  // If a zoom was moved, the focal length with which the image was taken over the lens's. The pose is right,
  // but whoever uses the image needs another lens for it.
  std::optional<double> focal_ratio;
  int lens_revision = 0;  // how often the tracker has replaced the given lens (LensUse::kRefine)
  // Changes when much of the map has moved (a closed loop): ask PoseOf() for all poses again.
  int map_revision = 0;
  // The map points that support the pose, for NoteView(); null if there are none.
  std::shared_ptr<const std::vector<MapObservation>> seen = {};
  double cpu_s = 0;   // processor time of tracking, without mapping even if that ran inside Step()
  StageTimes stages;  // processor time by stage; the sum is a little less
};

// A point that supports the last frame's pose.
struct VisiblePoint {
  Eigen::Vector3d position_in_world = Eigen::Vector3d::Zero();
  Eigen::Vector2d img = Eigen::Vector2d::Zero();  // pixel centres at integer + 0.5
  double depth = 0;                               // along the optical axis, world units
};

// A map point that the last frame should show.
struct ExpectedPoint {
  Eigen::Vector3d position_in_world = Eigen::Vector3d::Zero();
  double find_rate = 0;    // as in Candidate (map_matching.h), from the earlier frames
  int times_expected = 0;  // number of earlier frames that should have shown it
  bool found = false;      // in this frame, where the pose projects it
};

// Returns a frame's outcome for the operator's line of progress: what is the matter and what to do.
std::string InWords(const Track& track, FrameSource source);

// Returns how far the zoom was moved (Track::focal_ratio), and what to do.
std::string ZoomInWords(double focal_ratio, FrameSource source);

}  // namespace ulf::tracking
