#include <spdlog/spdlog.h>

#include "tracking/board_from_map.h"
#include "tracking/marker_locator.h"
#include "tracking/pose_source.h"
#include "tracking/thread_clock.h"

namespace ulf {
namespace {

// The board gives poses at once, the world and its metre. Meanwhile the tracker begins a map of its own,
// whose place in the board's frame is learnt from frames that have both; from then on features carry, which
// are steadier than a board's corners. Where the board is out of sight features go on; where features fail
// the board carries.
class FeaturesAndMarkers : public PoseSource {
 public:
  FeaturesAndMarkers(const CameraModel& camera, const MarkerSpec& spec, const TrackerOptions& options)
      : locator_(camera, spec),
        tracker_(camera, options),
        given_(MakeKnownPoseSource(camera, Subject{spec.Middle(), 0.1})) {}

  Track Step(const Frame& frame) override {
    Track track = tracker_.Step(frame);
    const double tracker_cpu_s = track.cpu_s, start_s = ThreadCpuSeconds();
    if (track.map_id != map_id_) frames_.Clear();
    map_id_ = track.map_id;
    std::optional<MarkerPose> pose;
    const bool tracked = track.cam_from_world.has_value();
    // While features carry the board is only a check now and then.
    const int look_every = tracked && frames_.Pairs() >= kPlentyPairs ? 3 : 1;
    if (!track.skipped && ++since_looked_ >= look_every) {
      since_looked_ = 0;
      pose = locator_.Locate(GrayForTracking(frame.image), frame.device_time_s);
    }
    if (tracked && pose && !pose->by_history) {
      frames_.Add(*track.anchor, *pose);
      if (frames_.Pairs() % kUpdateEvery == 0 || !frames_.Known()) frames_.Update(tracker_);
    }
    on_map_ = tracked && frames_.Known();
    if (on_map_) ToBoard(track);
    if (on_map_ && pose && (IsFarOff(*track.cam_from_world, *pose) || IsSurer(*pose, track))) on_map_ = false;
    if (!on_map_) track = CarriedByBoard(frame, pose);
    ++(on_map_ ? by_features_ : by_board_);
    track.map_id = 0;  // one world: the board's
    track.cpu_s = tracker_cpu_s + ThreadCpuSeconds() - start_s;
    track.relocalized = track.cam_from_world && began_ && lost_;
    if (!track.skipped) lost_ = !track.cam_from_world;
    began_ = began_ || track.cam_from_world;
    return track;
  }

  std::optional<Track> Locate(const Frame& photograph, const CameraModel& camera,
                              const std::optional<Rigid3>& near) const override {
    if (frames_.Known()) {
      std::optional<Rigid3> near_in_map;
      if (near) near_in_map = frames_.ToMap(*near);
      if (auto track = tracker_.Locate(photograph.image, camera, near_in_map)) {
        ToBoard(*track);
        return track;
      }
    }
    auto track = LocateByMarkers(locator_, photograph, camera);
    if (track) track->anchor = Anchored{kInBoardFrame, *track->cam_from_world};
    return track;
  }
  Rigid3 PoseOf(const Anchored& anchor) const override {
    if (anchor.keyframe_id == kInBoardFrame) return anchor.cam_from_keyframe;
    return frames_.ToBoard(tracker_.PoseOf(anchor));
  }
  std::vector<VisiblePoint> VisiblePoints() const override {
    if (!on_map_) return visible_;
    auto visible = tracker_.VisiblePoints();
    for (VisiblePoint& point : visible) {
      point.position_in_world = frames_.ToBoard(point.position_in_world);
      point.depth *= frames_.Scale();
    }
    return visible;
  }
  std::vector<ScenePoint> Points() const override {
    if (!frames_.Known()) return {};
    auto points = tracker_.Points();
    for (ScenePoint& point : points) point.position_in_world = frames_.ToBoard(point.position_in_world);
    return points;
  }
  // The recorded views' world is the board's already, and stays as it is.
  bool SeedMap(std::span<const SeedView> views) override {
    if (!tracker_.SeedMap(views)) return false;
    frames_.Hold();
    return true;
  }
  void Finish() override {
    tracker_.Finish();
    frames_.Update(tracker_);
    spdlog::debug("markers: {} frames by features, {} by the board; a unit of the map is {:.4f} m",
                  by_features_, by_board_, frames_.Scale());
  }
  TrackerStatistics Statistics() const override { return tracker_.Statistics(); }
  bool IsMetric() const override { return true; }

 private:
  static constexpr int kInBoardFrame = -2;  // an anchor that no adjustment moves
  static constexpr std::size_t kPlentyPairs = 60, kUpdateEvery = 10;

  void ToBoard(Track& track) const {
    track.cam_from_world = frames_.ToBoard(*track.cam_from_world);
    if (track.center_sigma) *track.center_sigma *= frames_.Scale();
  }

  // A map that the board contradicts is not believed for this frame.
  static bool IsFarOff(const Rigid3& by_map, const MarkerPose& pose) {
    if (pose.by_history) return false;
    constexpr double kFar = 0.05;  // of the distance, or radians
    const double off = (by_map.OriginInSource() - pose.cam_from_world.OriginInSource()).norm();
    const double turned = RotationAngle(by_map.rotation * pose.cam_from_world.rotation.conjugate());
    const double sigma = pose.center_sigma / pose.distance;
    const bool far = off > (kFar + 5 * sigma) * pose.distance || turned > kFar + 5 * sigma;
    if (far)
      spdlog::debug("markers: the map is {:.3f} m and {:.3f} off the board: not believed", off, turned);
    return far;
  }

  // Where little but the board is left in sight, it knows better.
  static bool IsSurer(const MarkerPose& pose, const Track& track) {
    return !pose.by_history && pose.center_sigma < *track.center_sigma;
  }

  Track CarriedByBoard(const Frame& frame, const std::optional<MarkerPose>& pose) {
    Track track = given_->Step(WithPose(frame, pose));
    visible_.clear();
    if (pose) {
      Describe(*pose, track);
      track.anchor = Anchored{kInBoardFrame, pose->cam_from_world};
      visible_ = VisibleCorners(*pose);
    } else {
      track.state = began_ ? TrackState::kLost : TrackState::kInitializing;
    }
    return track;
  }

  MarkerLocator locator_;
  Tracker tracker_;
  std::unique_ptr<PoseSource> given_;  // judges sharpness and motion while the board carries
  BoardFromMap frames_;
  bool on_map_ = false, began_ = false, lost_ = false;
  int map_id_ = 0, since_looked_ = 0, by_features_ = 0, by_board_ = 0;
  std::vector<VisiblePoint> visible_;
};

}  // namespace

std::unique_ptr<PoseSource> MakeFeaturesAndMarkersSource(const CameraModel& camera, const MarkerSpec& spec,
                                                         const TrackerOptions& options) {
  return std::make_unique<FeaturesAndMarkers>(camera, spec, options);
}

}  // namespace ulf
