#include <spdlog/spdlog.h>

#include "core/base/error.h"
#include "core/geometry/trajectory.h"
#include "tracking/sources/pose_sources.h"

namespace ulf::tracking {
namespace {

using NamedCounts = std::vector<std::pair<std::string, std::uint64_t>>;

// Adds the poses to the frames, which then have known poses.
class OutsidePoses : public PoseSource {
 public:
  OutsidePoses(const CameraModel& camera, const std::optional<Subject>& subject, const Rigid3& tool_from_cam)
      : given_(MakeKnownPoseSource(camera, subject, true)), tool_from_cam_(tool_from_cam) {}

  Track Step(const Frame& frame) override {
    Track track = given_->Step(Posed(frame));
    if (!track.skipped) continuity_.Complete(track);
    return track;
  }
  std::optional<Track> Locate(const Frame& photograph, const CameraModel& camera,
                              const std::optional<Rigid3>& near) const override {
    return given_->Locate(Posed(photograph), camera, near);
  }
  Rigid3 PoseOf(const Anchored& anchor) const override { return given_->PoseOf(anchor); }
  bool IsMetric() const override { return true; }

 protected:
  virtual std::optional<Rigid3> WorldFromTool(const Frame& frame) const = 0;

 private:
  Frame Posed(Frame frame) const {
    frame.known_cam_from_world.reset();
    if (frame.status == FrameStatus::kComplete)
      if (const auto world_from_tool = WorldFromTool(frame))
        frame.known_cam_from_world = (*world_from_tool * tool_from_cam_).Inverse();
    return frame;
  }

  std::unique_ptr<PoseSource> given_;
  Rigid3 tool_from_cam_;
  PoseContinuity continuity_;
};

class TrajectorySource : public OutsidePoses {
 public:
  TrajectorySource(const CameraModel& camera, const std::filesystem::path& file,
                   const TrajectoryOptions& options, const std::optional<Subject>& subject)
      : OutsidePoses(camera, subject, options.tool_from_cam),
        file_(file),
        offset_s_(options.offset_s),
        history_(options.max_gap_s) {
    for (const TimedPose& pose : ReadTum(file)) {
      history_.Add(pose.time_s, pose.cam_from_world.Inverse());
      ++counts_.poses;
    }
    if (history_.empty()) throw Error("{}: holds no poses", file.string());
  }
  void Finish() override {
    if (counts_.found == 0 && counts_.outside + counts_.in_gap > 0)
      spdlog::warn("{}: no frame has a pose, because the clocks differ; give offset_s", file_.string());
  }
  NamedCounts Counts() const override {
    return {{"poses", counts_.poses},
            {"frames_posed", counts_.found},
            {"frames_in_gaps", counts_.in_gap},
            {"frames_outside", counts_.outside}};
  }

 protected:
  std::optional<Rigid3> WorldFromTool(const Frame& frame) const override {
    Rigid3 pose;
    switch (history_.At(frame.device_time_s + offset_s_, &pose)) {
      case PoseLookup::kFound:
        ++counts_.found;
        return pose;
      case PoseLookup::kGap:
        ++counts_.in_gap;
        return std::nullopt;
      default:
        ++counts_.outside;
        return std::nullopt;
    }
  }

 private:
  std::filesystem::path file_;
  double offset_s_;
  PoseHistory history_;
  mutable struct { std::uint64_t poses = 0, found = 0, in_gap = 0, outside = 0; } counts_;
};

class StreamSource : public OutsidePoses {
 public:
  StreamSource(const CameraModel& camera, std::unique_ptr<PoseStream> stream, const Rigid3& tool_from_cam,
               const std::optional<Subject>& subject)
      : OutsidePoses(camera, subject, tool_from_cam), stream_(std::move(stream)) {
    spdlog::info("listening for poses on 127.0.0.1:{}", stream_->Port());
  }
  void Finish() override {
    const auto counts = stream_->Statistics();
    if (counts.connections == 0)
      spdlog::warn("tcp:{}: no program connected to send poses; start the sender first", stream_->Port());
    else if (counts.found == 0)
      spdlog::warn(
          "tcp:{}: none of the poses that arrived ({}) has a frame's time; give the clock that they are "
          "timed by (clock=host or device)",
          stream_->Port(), counts.poses);
    if (counts.malformed > 0)
      spdlog::warn("tcp:{}: lines that cannot be read: {}; the first: {}", stream_->Port(), counts.malformed,
                   counts.first_malformed);
  }
  NamedCounts Counts() const override {
    const auto counts = stream_->Statistics();
    return {{"poses", counts.poses},
            {"malformed_lines", counts.malformed},
            {"out_of_order", counts.out_of_order},
            {"connections", counts.connections},
            {"refused", counts.refused},
            {"frames_posed", counts.found},
            {"frames_in_gaps", counts.in_gap},
            {"frames_before", counts.before},
            {"frames_not_in_time", counts.not_in_time}};
  }

 protected:
  std::optional<Rigid3> WorldFromTool(const Frame& frame) const override {
    return stream_->WorldFromTool(frame.device_time_s, frame.host_time_s);
  }

 private:
  std::unique_ptr<PoseStream> stream_;
};

}  // namespace

std::unique_ptr<PoseSource> MakeTrajectorySource(const CameraModel& camera, const std::filesystem::path& file,
                                                 const TrajectoryOptions& options,
                                                 const std::optional<Subject>& subject) {
  return std::make_unique<TrajectorySource>(camera, file, options, subject);
}

std::unique_ptr<PoseSource> MakeStreamSource(const CameraModel& camera, std::unique_ptr<PoseStream> stream,
                                             const Rigid3& tool_from_cam,
                                             const std::optional<Subject>& subject) {
  return std::make_unique<StreamSource>(camera, std::move(stream), tool_from_cam, subject);
}

}  // namespace ulf::tracking
