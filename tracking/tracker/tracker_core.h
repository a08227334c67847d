// Holds the parts of a tracker and processes frames with them: private to tracker*.cpp. Pixels are those of
// the working size (working_size.h), except in frames, photographs and their fiducials.
#pragma once

#include <memory>
#include <optional>
#include <unordered_map>
#include <utility>
#include <vector>

#include "core/frames/frame.h"
#include "core/image/image.h"
#include "tracking/estimation/calibration_check.h"
#include "tracking/features/sharpness.h"
#include "tracking/map/frame_locator.h"
#include "tracking/map/mapper.h"
#include "tracking/map/pose_error.h"
#include "tracking/tracker/initializer.h"
#include "tracking/tracker/readout.h"
#include "tracking/tracker/readout_search.h"
#include "tracking/tracker/row_motion.h"
#include "tracking/tracker/start_progress.h"
#include "tracking/tracker/track.h"
#include "tracking/tracker/tracker_options.h"
#include "tracking/tracker/turn_tracker.h"
#include "tracking/tracker/working_size.h"
#include "tracking/tracker/zoom_watch.h"

namespace ulf::tracking {

// The velocity of the camera is known between frames that are at most so far apart. Guessed.
inline constexpr double kLongestStepS = 0.25;
// A map that is lost before it has been tracked for so many frames is discarded. Guessed.
inline constexpr int kProvenFrames = 10;
// A camera that has been lost for so long begins another part of the map. Guessed.
inline constexpr double kBeginPartAfterS = 1;

// The last frame that was tracked.
struct LastFrame {
  double time_s = 0;
  Anchored anchor;
  std::optional<Rigid3> velocity;  // the motion from the frame before: this camera from that camera
  std::unordered_map<int, Eigen::Vector2d> img_of_point;  // by id
  std::vector<VisiblePoint> visible;
  std::vector<ExpectedPoint> expected;
  std::optional<Twist> between;  // the velocity since the frame before
  int joins = 0;                 // SharedMap::joins then: a later join has moved the world of `visible`
};

inline MapperOptions MappingOf(const TrackerOptions& options) {
  MapperOptions mapping = options.mapping;
  mapping.check_lens = options.lens != LensUse::kFixed;
  mapping.seek_lens = options.lens == LensUse::kRefine && options.lens_is_guess;
  return mapping;
}

inline ReadoutUse UseOf(const TrackerOptions& options) {
  if (options.readout.readout_s) return ReadoutUse::kGiven;
  // An uncompensated rolling shutter looks like another lens.
  const bool compensate = options.readout.compensate_found || options.lens == LensUse::kRefine;
  return compensate ? ReadoutUse::kCompensate : ReadoutUse::kReport;
}

struct TrackerCore {
  // Starts with `map`, for example from a file; none: with an empty one.
  TrackerCore(const CameraModel& camera_in, const TrackerOptions& options_in, std::optional<Map> map = {})
      : size(camera_in, options_in.max_side_px),
        camera(size.working()),
        options(options_in),
        extractor(camera, options_in.corners),
        mapper(camera, map ? std::move(*map) : Map(camera), options_in.deterministic, MappingOf(options_in),
               options_in.seed),
        shared(mapper.shared()),
        locator(camera, shared, options_in.features),
        initializer(camera, options_in.seed),
        turns(camera, options_in.seed),
        rows(camera, options_in.readout.readout_s.value_or(0)),
        readout_search(rows, mapper, UseOf(options_in)) {}

  WorkingSize size;
  // The lens with which frames are tracked, in working pixels: size.working(), or that with its zoom moved.
  CameraModel camera;
  TrackerOptions options;
  FeatureExtractor extractor;
  Mapper mapper;  // owns the map
  const SharedMap& shared;
  FrameLocator locator;
  Initializer initializer;
  TurnTracker turns;  // while there is no pose
  ZoomWatch zoom;
  Sharpness sharpness;
  RowMotion rows;
  ReadoutSearch readout_search;
  std::optional<std::pair<double, Anchored>> frame_before;  // the one before the last: time and pose
  struct BeforeKeyframe {
    double time_s;
    Anchored anchor;
    double keyframe_time_s;
  };
  std::optional<BeforeKeyframe> before_keyframe;  // the frame before the last, if the last became a keyframe
  MapDriftEstimate map_drift;
  double world_information = 0;  // 1 / sigma^2 of the given world's place, from keyframes that showed it
  int revision = 0;              // of the map, when the last frame was tracked

  TrackState state = TrackState::kInitializing;
  LastFrame last;
  int frame = 0;
  int last_keyframe_frame = -1;
  double last_keyframe_s = 0;
  int frames_tracked = 0;                       // in the part in work; from kProvenFrames on it is kept
  int part = 0;                                 // the part in work: where the last frame was tracked
  std::unordered_map<int, int> frames_of_part;  // number of tracked frames by part
  std::optional<double> lost_since_s;
  int keyframes_left_out = 0;
  std::optional<RefinedLens> refined_lens;      // of working pixels
  int lens_revision = 0;                        // how often the lens was replaced
  std::optional<MapStart> map_start;            // of the present map
  std::optional<CalibrationCheck> calibration;  // of the last Finish()
  double mapping_cpu_s = 0;                     // of mapping inside Step()

  Track Step(const Frame& frame_in, const std::optional<FiducialObservation>& fiducials);
  void MoveWorld(const Similarity3& given_from_world);
  void AddWorldInformation(const TrackedImage& image);
  bool IsApart() const {
    const MapLock lock(shared);
    return part != shared.map.main_part();
  }
  bool RefineLens();
  void TrackWithLens(const CameraModel& lens);
  void PrepareLens();
  void WatchZoom(double time_s, const FramePose& frame_pose, Track& track);
  double ZoomByRows() const;
  void Initialize(TrackedImage& image, const Frame& frame_in, Track& track);
  void StartMap(const TwoViewStart& start, const cv::Mat& color);
  // These return whether the image has a pose now. `joins`: SharedMap::joins when it was found.
  bool Follow(TrackedImage& image, Track& track);
  bool Relocalize(TrackedImage& image, Track& track);
  bool ReturnToMainPart(TrackedImage& image, Track& track);
  bool ContinueFrom(FramePose found, int joins, TrackedImage& image, Track& track);
  unsigned SeedOfFrame() const { return options.seed + static_cast<unsigned>(frame); }
  bool MayBeginPart(double time_s) const;
  void Abandon();
  void ChooseMainPart();
  std::optional<Twist> VelocitySince(const Rigid3& last_pose, const Rigid3& pose, double time_s) const;
  std::optional<CalibrationCheck> InOriginalPixels(const std::optional<CalibrationCheck>& working) const;
  std::optional<RefinedLens> RefinedLensInOriginalPixels() const;
  // Returns false if parts of the map were joined since the pose was found.
  bool Accept(double time_s, const FramePose& frame_pose, int joins, Track& track);
  Anchored AnchorOf(const FramePose& frame_pose) const ULF_REQUIRES(shared.mutex);
  void Describe(const FramePose& frame_pose, const std::optional<Twist>& between, Track& track) const
      ULF_REQUIRES(shared.mutex);
  // World units.
  double RowsApart(const FramePose& frame_pose, const std::optional<Twist>& between, double distance) const;
  std::optional<Track> LocatePhotograph(const Image& image, const CameraModel& camera,
                                        const std::optional<Rigid3>& near,
                                        const std::optional<FiducialObservation>& fiducials) const;
  void Report(const TrackedImage& image, const Frame& frame_in, const FramePose& frame_pose, Track& track);
  std::optional<FrameReport::KeyframeVelocity> VelocityOfKeyframe(const TrackedImage& image,
                                                                  const FramePose& frame_pose);
  std::optional<NewKeyframe> KeyframeOf(const TrackedImage& image, const Frame& frame_in,
                                        const FramePose& frame_pose, StageTimes& stages) const;
  void FollowTurn(const TrackedImage& image, Track& track);
  bool IsMainPartHeld() const ULF_REQUIRES(shared.mutex);
  bool WantsKeyframe(const FramePose& frame_pose, double time_s, int reference_points) const;

  // The last frame that had a pose: turns are followed from it.
  std::shared_ptr<const FeatureSet> last_features_;
  Eigen::Quaterniond last_turn_ = Eigen::Quaterniond::Identity();
  std::optional<FramePose> frame_pose_;  // of the frame in work
  int joins_of_frame = 0;                // joins of the map's parts when it came
};

}  // namespace ulf::tracking
