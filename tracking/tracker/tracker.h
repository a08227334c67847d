// The tracker: frames in, camera poses out, in real time, without markers.
//
// Frame: the world is the first keyframe's camera until something metric says otherwise; its unit is the
// median depth of the first two-view map (so scale is arbitrary and the first median depth is 1). Poses are
// cam_from_world. Times are seconds, image quantities are pixels of the pictures as they come, angles are
// degrees where the name says so.
//
// Larger pictures are reduced to a working size before anything else (working_size.h): what goes in and comes
// out here knows nothing of it.
//
// How it works: ORB features spread over the image; two views start the map (homography or essential matrix,
// and a parallax test; rotation alone never starts it); every frame is matched against the map under a motion
// model and its pose refined robustly; keyframes go to the mapper, which triangulates, merges and adjusts in
// a second thread; a lost camera is found again by descriptors, P3P and guided verification. (Klein and
// Murray 2007 for the two threads; Mur-Artal, Montiel and Tardos 2015 for one descriptor through all stages;
// Forster et al. 2014 for aligning patches.)
//
// A live pose is the best known at its frame. Bundle adjustment moves keyframes later: whoever keeps a pose
// keeps its anchor (a keyframe and the rigid transform from it) and asks PoseOf() again at the end.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/base/stage_times.h"
#include "core/geometry/camera_model.h"
#include "core/geometry/rigid3.h"
#include "core/geometry/similarity3.h"
#include "core/image/frame.h"
#include "core/light_field/light_field.h"
#include "tracking/estimation/calibration_check.h"
#include "tracking/estimation/relative_pose.h"
#include "tracking/map/anchored.h"
#include "tracking/map/fiducial_observation.h"
#include "tracking/map/mapper_options.h"
#include "tracking/tracker/start_progress.h"

namespace ulf::tracking {

struct TrackerOptions {
  bool deterministic = false;  // mapping runs inside Step(): the same frames give the same bytes
  unsigned seed = 1;           // of every random draw
  int features = 850;          // per frame; twice as many while the map is being started
  int pyramid_levels = 8;      // that features are sought on, each 1 / 1.2 of the one before; 1 to 8
  int max_side_px = 960;       // pictures with a longer side are reduced to it; 0: tracked as they come
  // A live camera does not wait: when the mapper is behind, keyframes are left out. A replay waits instead.
  bool wait_for_mapper = false;
  // Of a rolling shutter, from the first row to the last (negative: from the last); 0: a global one. None:
  // looked for and said.
  std::optional<double> readout_s = {};
  bool compensate_found_readout =
      false;  // what is found without being told is also compensated from there on
  double min_initial_parallax_deg = 0.8;  // median over the two views that start the map
  MapperOptions mapping{};
};

enum class TrackState { kInitializing, kTracking, kLost };

// Where an image shows a map point: pixels of the image as it is, distortion and rolling shutter included.
struct MapObservation {
  int point = -1;
  Eigen::Vector2d img = Eigen::Vector2d::Zero();
};

// What became of one frame.
struct Track {
  TrackState state = TrackState::kInitializing;
  bool skipped = false;  // incomplete or empty frame: nothing was tried, the state stays
  int map_id =
      0;  // counts worlds: a map that is lost within its first ten frames is thrown away for a new one
  bool relocalized = false;  // found again in this frame after being lost
  // None unless tracking. Of a rolling shutter, whose rows have poses of their own: the one pose that
  // explains the picture best as it is. Whoever uses the picture (renderer, coverage, other programs) knows
  // no rows.
  std::optional<Rigid3> cam_from_world;
  std::optional<Anchored> anchor;  // the same pose, for PoseOf(); set whenever cam_from_world is
  // Where the camera itself was at the frame's time, when its middle row was read, relative to that pose: set
  // where a rolling shutter is compensated, else the same.
  std::optional<Rigid3> middle_row_from_picture;
  // 0 to 1, by the predicted error below: one half where that is a hundredth of the distance of what is seen.
  double quality = 0;
  int matched_points = 0;       // map points that support the pose
  std::optional<int> features;  // corners found in the picture; none: none were looked for
  // One standard deviation of the camera centre (world units), predicted: what the matches leave open and
  // what the map's own error is.
  std::optional<double> center_sigma;
  std::optional<StartProgress>
      start;              // while initialising, and of the frame that ended it: what it waits for
  double sharpness = 1;   // fine detail relative to the recent frames' median: well below 1 is blurred
  double speed_px = 0;    // median image motion of the tracked points since the frame before; 0: unknown
  bool keyframe = false;  // this frame was handed to the mapper
  // Changes when a closed loop or the like has moved much of the map: ask PoseOf() for all poses again.
  int map_revision = 0;
  // The map points that support the pose, for NoteView(); null where there are none.
  std::shared_ptr<const std::vector<MapObservation>> seen = {};
  double cpu_s = 0;   // CPU time of tracking, without mapping even where it ran inside Step()
  StageTimes stages;  // where it went; their sum is a little less
};

// A map point found in the last frame.
struct VisiblePoint {
  Eigen::Vector3d position_in_world = Eigen::Vector3d::Zero();
  Eigen::Vector2d img = Eigen::Vector2d::Zero();  // where it was seen, pixel centres at integer + 0.5
  double depth = 0;                               // along the optical axis, world units
};

// A map point that the last frame should have shown.
struct ExpectedPoint {
  Eigen::Vector3d position_in_world = Eigen::Vector3d::Zero();
  double find_rate = 0;    // how often it was found before when it was expected, 0 to 1
  int times_expected = 0;  // before
  bool found = false;      // where the frame's pose says that it is
};

// A recorded view whose pose is known, to rebuild a map from.
struct SeedView {
  Image image;
  Rigid3 cam_from_world;
};

// Of a rolling shutter, from the first row to the last (negative: from the last).
struct Readout {
  double readout_s = 0;
  std::optional<double> sigma_s = {};  // where it was found out
  bool compensated = true;
  std::string InWords() const;  // a sentence
};
// {readout_ms, sigma_ms, compensated}; null where there is none.
nlohmann::ordered_json ToJson(const std::optional<Readout>& rolling);

// What the two views said that a map was started from.
struct MapStart {
  RelativePoseModel model = RelativePoseModel::kEssential;
  MotionEvidence evidence;
};

// What a picture's width and height are where it is tracked, and as it comes. Zero: nothing is tracked.
struct TrackedSize {
  int width = 0, height = 0;
  int original_width = 0, original_height = 0;
};

struct TrackerStatistics {
  int keyframes = 0;  // alive
  int map_points = 0;
  int keyframes_left_out = 0;                        // the mapper was behind
  int loops = 0;                                     // closed
  double longest_wait_s = 0;                         // for the map, because the mapper was just changing it
  std::optional<CalibrationCheck> calibration = {};  // after Finish(), where the map is large enough
  std::optional<Readout> rolling_shutter = {};       // none: global as far as is known
  int keyframes_made = 0, points_made = 0;           // of which those above are left
  std::optional<MapStart> start = {};                // of the last map; none: none was, or it was seeded
  TrackedSize size = {};
};

class Tracker {
 public:
  // Throws Error when the camera's intrinsics are out of range.
  explicit Tracker(const CameraModel& camera, const TrackerOptions& options = {});
  ~Tracker();
  Tracker(Tracker&&) noexcept;
  Tracker& operator=(Tracker&&) noexcept;

  // Follows one frame. Throws Error when its size is not the camera's. `fiducials`: what it shows of a given
  // world, kept until the map is moved there, from then on part of the pose and of the map; a lost tracker
  // looks where it says.
  Track Step(const Frame& frame, const std::optional<FiducialObservation>& fiducials = {});

  // Where another camera took a photograph of the same scene: a tethered camera's full resolution, beside the
  // live view that is tracked. `near`: about where, if anybody knows. None when unsure. Nothing of the
  // tracker changes. Throws Error when the photograph's size is not its camera's.
  std::optional<Track> Locate(const Image& photograph, const CameraModel& camera,
                              const std::optional<Rigid3>& near = {},
                              const std::optional<FiducialObservation>& fiducials = {}) const;

  // The world is the one that fiducials are given in from now on, and stays it as long as the map lives;
  // anchors mean poses there. VisiblePoints() and the last pose are of the new world as well.
  void MoveWorld(const Similarity3& given_from_world);
  bool WorldIsGiven() const;

  // Waits for the mapper, adjusts the whole map and asks it whether the focal length is right. Frames may
  // follow; call it again then.
  void Finish();

  // The pose that `anchor` means now. Any anchor ever given remains valid; one of a discarded map
  // (Track::map_id) keeps its pose in that map's world.
  Rigid3 PoseOf(const Anchored& anchor) const;

  // Map points that support the last frame's pose; empty unless tracking.
  std::vector<VisiblePoint> VisiblePoints() const;
  // Those, and the ones that were looked for in vain.
  std::vector<ExpectedPoint> ExpectedPoints() const;

  // The image that `track` is of was recorded as a view: its points are seen there. At once, before the next
  // Step().
  void NoteView(int view_id, const Track& track);

  // All map points with the colour they were seen in and the recorded views that show them.
  std::vector<ScenePoint> Points() const;

  // Anchors of all living keyframes, in order of time (each anchored to itself).
  std::vector<Anchored> Keyframes() const;

  // Builds a map from views with known poses (at least two that see the same things), keeping their world.
  // The tracker is then lost and finds itself with the next frame that sees the map. False, with the tracker
  // as it was before, when too few points could be triangulated.
  bool SeedMap(std::span<const SeedView> views);

  // The map as a file (map_file.h) for a tracker of another day, whole or not at all; `key` says what it
  // belongs to. Nothing is written while there is no map. Throws as WriteFileAtomically does.
  void SaveMap(const std::filesystem::path& file, std::uint64_t key) const;
  // Instead of SeedMap(), where such a file fits: the tracker is then lost and finds itself. Otherwise it
  // says what is wrong with the file, and the tracker is as it was.
  std::string RestoreMap(const std::filesystem::path& file, std::uint64_t key);

  TrackerStatistics Statistics() const;
  const CameraModel& camera() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace ulf::tracking
