// Which frames become keyframes, and what the mapper is told of a frame.
#include <algorithm>
#include <utility>

#include "core/base/at.h"
#include "core/base/host_time.h"
#include "core/base/quantile.h"
#include "core/geometry/angles.h"
#include "tracking/map/map_matching.h"
#include "tracking/tracker/tracker_core.h"

namespace ulf::tracking {

namespace {

// It is offered sooner when the frame has less than this share of the nearest keyframe's points, or fewer
// points than this, and the camera has moved or turned at least so far. Guessed.
constexpr double kKeyframeThinShare = 0.75;
constexpr int kKeyframeThinPoints = 80;
constexpr double kKeyframeThinMoved = 0.02;
constexpr double kKeyframeThinTurnedDeg = 4;
// The frame after a keyframe is none, unless it comes so much later: then the camera has moved on. Guessed.
constexpr double kKeyframeNextFrameAfterS = 0.07;

}  // namespace

bool TrackerCore::WantsKeyframe(const FramePose& frame_pose, double time_s, int reference_points) const {
  const int matched = static_cast<int>(frame_pose.matches.size());
  const MapperOptions& limits = options.mapping;
  if (frame == last_keyframe_frame + 1 && time_s - last_keyframe_s < kKeyframeNextFrameAfterS) return false;
  const Rigid3& pose = last.anchor.cam_from_keyframe;
  std::vector<double> depths;
  for (const VisiblePoint& point : last.visible) depths.push_back(point.depth);
  const double depth = std::max(1e-9, Median(depths));
  const double moved = pose.OriginInSource().norm() / depth;
  const double turned_deg = Degrees(RotationAngle(pose.rotation));
  const bool thin = matched < kKeyframeThinShare * reference_points || matched < kKeyframeThinPoints;
  const bool far = moved > limits.keyframe_moved || turned_deg > limits.keyframe_turned_deg;
  return (thin && (moved > kKeyframeThinMoved || turned_deg > kKeyframeThinTurnedDeg)) || far;
}

// Returns the velocity about the frame before, where that became a keyframe.
std::optional<FrameReport::KeyframeVelocity> TrackerCore::VelocityOfKeyframe(const TrackedImage& image,
                                                                             const FramePose& frame_pose) {
  const std::optional<BeforeKeyframe> before = std::exchange(before_keyframe, std::nullopt);
  if (!before || image.time_s - before->time_s >= 2 * kLongestStepS) return std::nullopt;
  const MapLock lock(shared);
  return FrameReport::KeyframeVelocity{
      before->keyframe_time_s, TwistBetween(shared.map.PoseOf(before->anchor), frame_pose.cam_from_world,
                                            image.time_s - before->time_s)};
}

std::optional<NewKeyframe> TrackerCore::KeyframeOf(const TrackedImage& image, const Frame& frame_in,
                                                   const FramePose& frame_pose, StageTimes& stages) const {
  const StageTimer timer(&stages.keyframe_s);
  {
    const MapLock lock(shared);
    if (!WantsKeyframe(frame_pose, image.time_s,
                       shared.map.keyframe(last.anchor.keyframe_id).points_at_birth))
      return std::nullopt;
  }
  NewKeyframe offered;
  offered.joins = joins_of_frame;
  offered.keyframe.part = part;
  offered.keyframe.time_s = image.time_s;
  offered.keyframe.cam_from_world = frame_pose.cam_from_world;
  offered.keyframe.pyramid = image.pyramid;
  offered.keyframe.velocity = last.between;
  offered.keyframe.color = size.Reduced(Srgb8(frame_in.image));
  if (shared.world_given)
    offered.keyframe.corners = image.fiducials ? image.fiducials->corners : std::vector<PointObservation>();
  else if (image.fiducials && !image.pyramid->rows)
    offered.keyframe.corners = image.fiducials->corners;
  locator.Describe(*image.features, frame_pose, offered);
  return offered;
}

// Tells the mapper which points the frame should have shown and did show, and offers it as a keyframe.
void TrackerCore::Report(const TrackedImage& image, const Frame& frame_in, const FramePose& frame_pose,
                         Track& track) {
  FrameReport report;
  for (const int i : frame_pose.in_view) report.expected.push_back(frame_pose.candidates[At(i)].id);
  for (const PointMatch& match : frame_pose.matches) report.found.push_back(frame_pose.CandidateOf(match).id);
  report.velocity = VelocityOfKeyframe(image, frame_pose);
  if (!track.keyframe && !zoom.Disagrees())
    report.keyframe = KeyframeOf(image, frame_in, frame_pose, track.stages);
  const bool offered = report.keyframe.has_value();
  const double before_s = ThreadCpuSeconds();
  const bool taken = mapper.Take(std::move(report));
  if (!offered) return;
  if (options.deterministic) mapping_cpu_s += ThreadCpuSeconds() - before_s;
  if (!taken) {
    ++keyframes_left_out;
    return;
  }
  track.keyframe = true;
  last_keyframe_frame = frame;
  last_keyframe_s = image.time_s;
  AddWorldInformation(image);
  if (frame_before) before_keyframe = {frame_before->first, frame_before->second, image.time_s};
  map_drift.Add(last.anchor, frame_pose.cam_from_world);
}

}  // namespace ulf::tracking
