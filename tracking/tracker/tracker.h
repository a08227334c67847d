// The tracker computes camera poses from frames, in real time, without markers.
//
// Frames and units: the world is the first keyframe's camera until MoveWorld(); its unit is the median depth
// of the first two-view map, so the scale is arbitrary. Poses are cam_from_world. Times are seconds, image
// quantities are pixels of the images as they come, angles are degrees where the name says so. Inside, larger
// images are reduced to a working size (working_size.h).
//
// Method: ORB features are spread over the image. Two views start the map (homography or essential matrix,
// and a parallax test; rotation alone never starts it). Every frame is matched against the map under a motion
// model, and its pose is refined robustly. Keyframes go to the mapper, which triangulates, merges and adjusts
// in a second thread. Descriptors, P3P and guided verification find a lost camera again. (Klein and Murray
// 2007 for the two threads; Mur-Artal, Montiel and Tardos 2015 for one descriptor through all stages; Forster
// et al. 2014 for aligning patches.)
//
// A live pose is the best known at its frame, and bundle adjustment moves keyframes later. To keep a pose,
// keep its anchor (a keyframe and the rigid transform from it) and ask PoseOf() again at the end.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <functional>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/base/stage_times.h"
#include "core/frames/frame.h"
#include "core/geometry/camera_model.h"
#include "core/geometry/rigid3.h"
#include "core/geometry/similarity3.h"
#include "core/light_field/light_field.h"
#include "tracking/estimation/calibration_check.h"
#include "tracking/estimation/relative_pose.h"
#include "tracking/estimation/rolling_shutter.h"
#include "tracking/map/anchored.h"
#include "tracking/map/fiducial_observation.h"
#include "tracking/tracker/start_progress.h"
#include "tracking/tracker/tracker_options.h"

namespace ulf::tracking {

enum class TrackState {
  kInitializing,
  kTracking,
  kLost,
  // Followed in a part of the map whose place in the main part's world is not known (yet): there is no pose, but an
  // anchor, which tells the pose as soon as the parts are joined.
  kApart
};

// The result for one frame.
struct Track {
  TrackState state = TrackState::kInitializing;
  bool skipped = false;  // incomplete or empty frame: nothing was tried, the state stays
  // The map in whose world the pose is: a map that is lost within its first frames is discarded for another, and a
  // part of the map that was followed for longer takes the place of the main part, unless views are recorded in that.
  int map_id = 0;
  bool relocalized = false;  // found again in this frame after being lost
  // None unless tracking. With a rolling shutter, whose rows have poses of their own: the one pose that
  // explains the image best as it is, because users of the image (renderer, coverage, other programs) know no
  // rows.
  std::optional<Rigid3> cam_from_world;
  // The same pose, for PoseOf(); set whenever cam_from_world is, and while kApart.
  std::optional<Anchored> anchor;
  // While there is no pose: how the camera is turned, where that is known although its position is not. From the world of
  // the last pose; before a map has started, from the camera of the first frame.
  std::optional<Eigen::Quaterniond> turn;
  // The camera's own pose when the middle row was read, relative to cam_from_world; set where a rolling
  // shutter is compensated, else the two are the same.
  std::optional<Rigid3> middle_row_from_picture;
  // The camera's velocity while the rows were read, in the middle row's frame; set where middle_row_from_picture is.
  std::optional<Twist> twist;
  // 0 to 1, from PictureSigma() and lens_error_share: one half where they come to a hundredth of the distance of what is
  // seen.
  double quality = 0;
  int matched_points = 0;       // map points that support the pose
  std::optional<int> features;  // corners detected in the image; none: the source detects none
  // Predicted standard deviation of the camera's centre, world units: from the matches and the map's error.
  std::optional<double> center_sigma;
  // With a rolling shutter, how far the picture's one pose is from those of its rows, world units.
  double rows_sigma = 0;
  double distance = 0;  // of the points that support the pose, median, world units; 0: unknown
  // The predicted error of the centre, rows included; none: center_sigma is none.
  std::optional<double> PictureSigma() const;
  std::optional<StartProgress> start;  // while initializing, and for the frame that started the map
  double sharpness = 1;                // fine detail over the recent frames' median: well below 1 is blurred
  double speed_px = 0;      // median image motion of the tracked points since the frame before; 0: unknown
  bool keyframe = false;    // the mapper took this frame as a keyframe
  bool wrong_lens = false;  // the map contradicts the given lens: Statistics() says how
  // By what share of the distance that lens puts poses wrong. `quality` alone counts it: a view under a wrong lens is worth
  // recording, because `ulf refine` finds the lens.
  double lens_error_share = 0;
  // A zoom was moved: the focal length that the image was taken with, over the lens's. The pose is right; whoever uses the
  // image needs its own lens.
  std::optional<double> focal_ratio;
  int lens_revision = 0;  // how often the tracker has replaced the given lens (LensUse::kRefine)
  // Changes when a closed loop, for example, has moved much of the map: ask PoseOf() for all poses again.
  int map_revision = 0;
  // The map points that support the pose, for NoteView(); null where there are none.
  std::shared_ptr<const std::vector<MapObservation>> seen = {};
  double cpu_s = 0;   // CPU time of tracking, without mapping even where that ran inside Step()
  StageTimes stages;  // CPU time by stage; the sum is a little less
};

// A map point found in the last frame.
struct VisiblePoint {
  Eigen::Vector3d position_in_world = Eigen::Vector3d::Zero();
  Eigen::Vector2d img = Eigen::Vector2d::Zero();  // pixel centres at integer + 0.5
  double depth = 0;                               // along the optical axis, world units
};

// A map point that the last frame should have shown.
struct ExpectedPoint {
  Eigen::Vector3d position_in_world = Eigen::Vector3d::Zero();
  double find_rate = 0;    // share of the frames before that should have shown it in which it was found
  int times_expected = 0;  // frames before that should have shown it
  bool found = false;      // in this frame, where the pose projects it
};

// A recorded view with a known pose, to build a map from.
using SeedProgress = std::function<void(std::size_t views)>;
struct SeedView {
  Image image;
  Rigid3 cam_from_world;
};

// A rolling shutter.
struct Readout {
  double readout_s = 0;                // from the first row to the last; negative: from the last
  std::optional<double> sigma_s = {};  // one standard deviation, where the tracker measured it
  bool compensated = true;
  // One that was given, where the map's images contradict it: what they tell, and one standard deviation of that.
  struct Contradiction {
    double readout_s = 0, sigma_s = 0;
  };
  std::optional<Contradiction> contradicted = {};
  std::string InWords() const;  // a sentence
};
// {readout_ms, sigma_ms, compensated, contradicted_by_ms}; null for a global shutter.
nlohmann::ordered_json ToJson(const std::optional<Readout>& rolling);

// The model and the evidence of the two views that started a map.
struct MapStart {
  RelativePoseModel model = RelativePoseModel::kEssential;
  MotionEvidence evidence;
};

// Width and height of the images as they are tracked, and as they come. Zero: nothing is tracked.
struct TrackedSize {
  int width = 0, height = 0;
  int original_width = 0, original_height = 0;
};

struct TrackerStatistics {
  int keyframes = 0;  // alive
  int map_points = 0;
  int keyframes_left_out = 0;  // because the mapper was behind
  int loops = 0;               // closed
  int parts_joined = 0;        // parts of the map that were begun by themselves
  int parts = 0;               // of the map; more than one: apart from each other
  double longest_wait_s = 0;   // for the mapper to release the map
  // After Finish(), where the map is large enough; before, from the moment on at which the map contradicts the lens.
  std::optional<CalibrationCheck> calibration = {};
  // The lens that replaced the given one, of the images as they come.
  std::optional<RefinedLens> refined_lens = {};
  std::optional<Readout> rolling_shutter = {};  // none: global as far as is known
  int keyframes_made = 0, points_made = 0;      // in all
  std::optional<MapStart> start = {};           // of the last map; none: no start, or a seeded map
  TrackedSize size = {};
};

class Tracker {
 public:
  // Throws Error when the camera's intrinsics are out of range.
  explicit Tracker(const CameraModel& camera, const TrackerOptions& options = {});
  ~Tracker();
  Tracker(Tracker&&) noexcept;
  Tracker& operator=(Tracker&&) noexcept;

  // Tracks one frame. Throws Error when its size is not the camera's. `fiducials`: what the frame shows of a
  // given world; keyframes keep it until the map is moved there, from then on it is part of the pose and of
  // the map, and a lost tracker searches where it says.
  Track Step(const Frame& frame, const std::optional<FiducialObservation>& fiducials = {});

  // Finds where another camera took a photograph of the same scene: a tethered camera's full resolution
  // beside its live view. `near`: about where, if known. None when the pose is not certain. Throws Error when
  // the photograph's size is not its camera's. None, too, while a zoom is moved.
  std::optional<Track> Locate(const Image& photograph, const CameraModel& camera,
                              const std::optional<Rigid3>& near = {},
                              const std::optional<FiducialObservation>& fiducials = {}) const;

  // Moves the map into the world in which fiducials are given, for as long as the map lives. Anchors,
  // VisiblePoints() and the last pose follow.
  void MoveWorld(const Similarity3& given_from_world);
  bool WorldIsGiven() const;

  // Waits for the mapper, adjusts the whole map and checks the focal length against it. Frames may follow;
  // call it again then.
  void Finish();

  // The pose that `anchor` means now. Every anchor stays valid; one of a discarded map (Track::map_id) keeps
  // its pose in that map's world.
  Rigid3 PoseOf(const Anchored& anchor) const;

  // The pose of a frame's track now: PoseOf() its anchor, and where the lens was replaced since, solved again from the
  // points that the frame showed. None where it had neither. It lies in the world of MapNow().
  std::optional<Rigid3> PoseNow(const Track& track) const;
  // Track::map_id, after parts of the map were joined since.
  int MapNow(const Track& track) const;

  // Map points that support the last frame's pose; empty unless kTracking.
  std::vector<VisiblePoint> VisiblePoints() const;
  // Those, and the ones that the last frame should have shown and did not.
  std::vector<ExpectedPoint> ExpectedPoints() const;

  // The image of `track` was recorded as a view: notes its points. Call it before the next Step().
  void NoteView(int view_id, const Track& track);

  // All points of the main part with their colours and the recorded views that show them.
  std::vector<ScenePoint> Points() const;

  // Builds a map from views with known poses (at least two that see the same things), in their world. The
  // tracker is then lost and relocalizes with the next frame that sees the map. Returns false, and stays as
  // it was, when too few points could be triangulated.
  // `progress` hears how many views are in the map.
  bool SeedMap(std::span<const SeedView> views, const SeedProgress& progress = {});

  // Writes the map to a file (map_file.h) for another session, whole or not at all; `key` says what it
  // belongs to. Writes nothing while there is no map. Throws as WriteFileAtomically does.
  void SaveMap(const std::filesystem::path& file, std::uint64_t key) const;
  // Instead of SeedMap(), with such a file: the tracker is then lost and relocalizes. Where the file does not
  // fit it returns what is wrong, and the tracker stays as it was.
  std::string RestoreMap(const std::filesystem::path& file, std::uint64_t key);

  TrackerStatistics Statistics() const;
  const CameraModel& camera() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace ulf::tracking
