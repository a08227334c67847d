#include <spdlog/spdlog.h>

#include "core/base/counted.h"
#include "core/base/host_time.h"
#include "tracking/sources/marker_locator.h"
#include "tracking/sources/pose_sources.h"

namespace ulf::tracking {
namespace {

class MarkerSource : public PoseSource {
 public:
  MarkerSource(const CameraModel& camera, const MarkerSpec& spec)
      : locator_(camera, spec), given_(MakeKnownPoseSource(camera, Subject{spec.Middle(), 0.1})) {}

  Track Step(const Frame& frame) override {
    const double start_s = ThreadCpuSeconds();
    const std::optional<MarkerPose> pose = locator_.Locate(frame);
    Track track = given_->Step(WithPose(frame, pose));
    visible_.clear();
    if (pose) {
      Describe(*pose, track);
      visible_ = VisibleCorners(*pose);
    }
    continuity_.Complete(track);
    track.cpu_s = ThreadCpuSeconds() - start_s;
    return track;
  }
  std::optional<Track> Locate(const Frame& photograph, const CameraModel& camera,
                              const std::optional<Rigid3>& /*near*/) const override {
    const auto pose = LocateByMarkers(locator_, photograph, camera);
    if (!pose) return std::nullopt;
    Track track;
    Describe(*pose, track);
    track.anchor = Anchored{0, pose->cam_from_world};
    return track;
  }
  Rigid3 PoseOf(const Anchored& anchor) const override { return anchor.cam_from_keyframe; }
  std::vector<VisiblePoint> VisiblePoints() const override { return visible_; }
  bool IsMetric() const override { return true; }
  void Finish() override {
    if (const std::string world = locator_.WorldInWords(); !world.empty()) spdlog::info("markers: {}", world);
    if (locator_.AmbiguousFrames() > 0)
      spdlog::info(
          "markers: {} without a pose, because two poses were equally likely; larger or more markers help",
          Counted(locator_.AmbiguousFrames(), "frame"));
  }

 private:
  MarkerLocator locator_;
  std::unique_ptr<PoseSource> given_;  // measures sharpness and motion
  std::vector<VisiblePoint> visible_;
  PoseContinuity continuity_;
};

}  // namespace

std::unique_ptr<PoseSource> MakeMarkerSource(const CameraModel& camera, const MarkerSpec& spec) {
  return std::make_unique<MarkerSource>(camera, spec);
}

}  // namespace ulf::tracking
