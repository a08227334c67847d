#include <spdlog/spdlog.h>

#include "core/base/at.h"
#include "core/base/host_time.h"
#include "tracking/sources/board_from_map.h"
#include "tracking/sources/marker_locator.h"
#include "tracking/sources/pose_sources.h"

namespace ulf::tracking {
namespace {

// The board gives poses from the first frame on, in its own frame and in metres, while the tracker starts a
// map. Frames that have both poses determine the map's place in the board's frame. Then the map moves there,
// and the board's corners become part of it and of every frame's pose (fiducial_observation.h). Where the
// board is out of sight, the tracker continues with features. Where features fail, the board gives the pose,
// which also tells a lost tracker where to search.
class FeaturesAndMarkers : public PoseSource {
 public:
  // The board holds the world: a camera that is lost looks for it.
  static TrackerOptions WithoutParts(TrackerOptions options) {
    options.begin_parts = false;
    return options;
  }

  FeaturesAndMarkers(const CameraModel& camera, const MarkerSpec& spec, const TrackerOptions& options)
      : locator_(camera, spec),
        tracker_(camera, WithoutParts(options)),
        given_(MakeKnownPoseSource(camera, Subject{spec.Middle(), 0.1})) {}

  Track Step(const Frame& frame) override {
    const double start_s = ThreadCpuSeconds();
    const std::optional<MarkerPose> pose = locator_.Locate(frame);
    const double located_s = ThreadCpuSeconds();
    Track track = tracker_.Step(frame, FiducialsOf(pose));
    const double tracker_cpu_s = track.cpu_s, tracked_s = ThreadCpuSeconds();
    if (track.map_id != map_id_) board_from_map_.Clear();
    map_id_ = track.map_id;
    if (track.cam_from_world && pose && !pose->by_history && !tracker_.WorldIsGiven()) FitWorld(*pose, track);
    on_map_ = track.cam_from_world && tracker_.WorldIsGiven() &&
              !(pose && DisagreesWithBoard(*track.cam_from_world, *pose));
    if (!on_map_) track = TrackByBoard(frame, pose, tracker_.WorldIsGiven() ? std::nullopt : track.anchor);
    frames_by_features_ += on_map_;
    track.map_id = 0;  // one world: the board's
    track.cpu_s = tracker_cpu_s + (located_s - start_s) + (ThreadCpuSeconds() - tracked_s);
    continuity_.Complete(track);
    return track;
  }

  std::optional<Track> Locate(const Frame& photograph, const CameraModel& camera,
                              const std::optional<Rigid3>& near) const override {
    const auto pose = LocateByMarkers(locator_, photograph, camera);
    if (tracker_.WorldIsGiven()) {
      const std::optional<Rigid3> expected = pose ? pose->cam_from_world : near;
      if (auto track = tracker_.Locate(photograph.image, camera, expected, FiducialsOf(pose)))
        if (!pose || !DisagreesWithBoard(*track->cam_from_world, *pose)) return track;
    }
    if (!pose) return std::nullopt;
    Track track;
    Describe(*pose, track);
    track.anchor = Anchored{kFixedBoardPose, pose->cam_from_world};
    return track;
  }
  Rigid3 PoseOf(const Anchored& anchor) const override {
    if (anchor.keyframe_id == kFixedBoardPose) return anchor.cam_from_keyframe;
    if (anchor.keyframe_id > kFirstBoardPose) return tracker_.PoseOf(anchor);
    const ByBoard& given = by_board_[At(kFirstBoardPose - anchor.keyframe_id)];
    return given.in_map && given.map_id == map_id_ && tracker_.WorldIsGiven() ? tracker_.PoseOf(*given.in_map)
                                                                              : given.cam_from_board;
  }
  std::vector<VisiblePoint> VisiblePoints() const override {
    return on_map_ ? tracker_.VisiblePoints() : visible_;
  }
  std::vector<ExpectedPoint> ExpectedPoints() const override {
    return on_map_ ? tracker_.ExpectedPoints() : std::vector<ExpectedPoint>();
  }
  void NoteView(int view_id, const Track& track) override { tracker_.NoteView(view_id, track); }
  std::vector<ScenePoint> Points() const override {
    return tracker_.WorldIsGiven() ? tracker_.Points() : std::vector<ScenePoint>();
  }
  // The recorded views are in the board's frame already.
  bool SeedMap(std::span<const SeedView> views, const SeedProgress& progress) override {
    if (!tracker_.SeedMap(views, progress)) return false;
    tracker_.MoveWorld({});
    return true;
  }
  // A map in a world of its own is of no use to a later session.
  void SaveMap(const std::filesystem::path& file, std::uint64_t key) const override {
    if (tracker_.WorldIsGiven()) tracker_.SaveMap(file, key);
  }
  std::optional<MapRefusal> RestoreMap(const std::filesystem::path& file, std::uint64_t key) override {
    std::optional<MapRefusal> refusal = tracker_.RestoreMap(file, key);
    if (!refusal) tracker_.MoveWorld({});
    return refusal;
  }
  void Finish() override {
    tracker_.Finish();
    if (const std::string world = locator_.WorldInWords(); !world.empty()) spdlog::info("markers: {}", world);
    spdlog::debug("markers: {} frames by features, {} by the board", frames_by_features_, by_board_.size());
  }
  TrackerStatistics Statistics() const override { return tracker_.Statistics(); }
  bool IsMetric() const override { return true; }

 private:
  // A map pose is not used that differs from an unambiguous board pose by more than this (of the distance, or
  // radians) and this many of the board pose's standard deviations. Guessed.
  static constexpr double kFar = 0.05, kFarSigmas = 5;
  // Anchors of poses that the board gave are numbered downwards from kFirstBoardPose. Where the tracker knew
  // the pose as well (`in_map`), its anchor is better once the map has moved.
  static constexpr int kFixedBoardPose = -2, kFirstBoardPose = -3;
  struct ByBoard {
    Rigid3 cam_from_board;
    std::optional<Anchored> in_map;
    int map_id = 0;
  };
  Anchored AnchorByBoard(const Rigid3& cam_from_board, const std::optional<Anchored>& in_map) {
    by_board_.push_back({cam_from_board, in_map, map_id_});
    return {kFirstBoardPose - static_cast<int>(by_board_.size()) + 1, cam_from_board};
  }

  static std::optional<FiducialObservation> FiducialsOf(const std::optional<MarkerPose>& pose) {
    return pose ? std::optional(FiducialObservation{pose->corners, pose->cam_from_world,
                                                    pose->by_history ? 0 : pose->center_sigma})
                : std::nullopt;
  }

  void FitWorld(const MarkerPose& pose, Track& track) {
    board_from_map_.Add(*track.anchor, pose);
    const auto board_from_map = board_from_map_.Fit(tracker_);
    if (!board_from_map) return;
    spdlog::debug("markers: the map moves into the board's frame; its unit is {:.4f} m",
                  board_from_map->scale);
    tracker_.MoveWorld(*board_from_map);
    track.cam_from_world = tracker_.PoseOf(*track.anchor);
    if (track.center_sigma) *track.center_sigma *= board_from_map->scale;
    track.rows_sigma *= board_from_map->scale;
    track.distance *= board_from_map->scale;
    if (track.twist) track.twist->tail<3>() *= board_from_map->scale;
    if (track.middle_row_from_picture) track.middle_row_from_picture->translation *= board_from_map->scale;
  }

  static bool DisagreesWithBoard(const Rigid3& by_map, const MarkerPose& pose) {
    if (pose.by_history) return false;
    const double off = (by_map.OriginInSource() - pose.cam_from_world.OriginInSource()).norm();
    const double turned = RotationAngle(by_map.rotation * pose.cam_from_world.rotation.conjugate());
    const double sigma = pose.center_sigma / pose.distance;
    const double most = kFar + kFarSigmas * sigma;
    const bool far = off > most * pose.distance || turned > most;
    if (far)
      spdlog::debug("markers: the map's pose is {:.3f} m and {:.3f} rad off the board's: not used", off,
                    turned);
    return far;
  }

  Track TrackByBoard(const Frame& frame, const std::optional<MarkerPose>& pose,
                     const std::optional<Anchored>& in_map) {
    Track track = given_->Step(WithPose(frame, pose));
    visible_.clear();
    if (pose) {
      Describe(*pose, track);
      track.anchor = AnchorByBoard(pose->cam_from_world, in_map);
      visible_ = VisibleCorners(*pose);
    }
    return track;
  }

  MarkerLocator locator_;
  Tracker tracker_;
  std::unique_ptr<PoseSource> given_;  // measures sharpness and motion while the board gives the pose
  BoardFromMap board_from_map_;
  PoseContinuity continuity_;
  bool on_map_ = false;
  int map_id_ = 0, frames_by_features_ = 0;
  std::vector<ByBoard> by_board_;
  std::vector<VisiblePoint> visible_;
};

}  // namespace

std::unique_ptr<PoseSource> MakeFeaturesAndMarkersSource(const CameraModel& camera, const MarkerSpec& spec,
                                                         const TrackerOptions& options) {
  return std::make_unique<FeaturesAndMarkers>(camera, spec, options);
}

}  // namespace ulf::tracking
