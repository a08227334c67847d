// Photographs taken beside live view: live frames are tracked and never recorded; where coverage wants a
// view, a photograph is asked for, one at a time; when it has come it is judged by itself.
//
// Between the request and the shutter the hand moves on. So the photograph's own pose is solved against the
// map, with the intrinsics that photographs have, and everything that was asked of the live frame is asked
// again of the photograph: does it see the subject whole, does it show anything that no recorded view shows,
// is it exposed and still enough. What passes is recorded. What does not, and what finds no pose, is kept in
// unposed/: a photograph is never thrown away. That holds for those that were released on the body, too.
//
// The shutter's lag, from the request to the exposure, no protocol tells. It is measured: the place on the
// live trajectory that is nearest to the photograph's own pose says when it was taken, on the clock of the
// live frames (live view's own delay is part of it, as it is of every later search). Counted are photographs
// that were asked for while the hand moved enough to tell times apart; the median is where later ones are
// looked for, unless the device was told a lag.
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "acquisition/calibration/intrinsics.h"
#include "acquisition/device/device.h"
#include "coverage/bound/view_decision.h"
#include "tracking/sources/pose_source.h"

namespace ulf::coverage {

struct StillCounts {
  std::uint64_t asked = 0;
  std::uint64_t arrived = 0;  // also those released on the body
  std::uint64_t recorded = 0;
  std::uint64_t not_needed = 0;  // with a pose, but covered by then, cropped, or of poor quality: in unposed/
  std::uint64_t without_pose = 0;  // in unposed/
  std::uint64_t lags = 0;          // measured
  std::optional<double> lag_s;     // their median
};

// A live frame's pose at its time.
struct LivePose {
  double time_s = 0;
  Rigid3 cam_from_world;
  double speed_px = 0;  // since the frame before, in photograph pixels
};

// When the trajectory passed `cam_from_world`, between its poses: by the angle that the subject would have
// moved in the image, the subject being `distance` away. None where the hand stood still or came by twice, so
// that the pose tells no time to within 50 ms, or where it lies before or behind all poses.
std::optional<double> TimeOnTrajectory(std::span<const LivePose> trajectory, const Rigid3& cam_from_world,
                                       double distance);

struct StillVerdict {
  Decision decision;                     // kRecorded: to be recorded; anything else: to be kept in unposed/
  std::optional<tracking::Track> track;  // where it was taken; none when that was not found
};

class StillCapture {
 public:
  // `camera`: of photographs.
  StillCapture(acquisition::Device& device, const CameraModel& camera, const tracking::PoseSource& poses,
               const DecisionLimits& limits, int coverage_width_px);

  const CameraModel& camera() const { return camera_; }
  const StillCounts& counts() const { return counts_; }

  // What the hand does: a photograph is looked for where the live view was last.
  void Follow(const Frame& live, const tracking::Track& track);
  // A photograph is wanted from here. Nothing happens while one is on its way.
  void Ask();
  StillVerdict Judge(const Frame& still, const CoverageMap* map);

 private:
  // A photograph whose lag is measured when live view has gone on.
  struct Unmeasured {
    double requested_s = 0, judged_s = 0;
    Rigid3 cam_from_world;
    double distance = 0;
  };
  double ExpectedTime(const Frame& still) const;
  void MeasureLags();
  std::optional<Rigid3> LivePoseAt(double time_s) const;
  double SpeedPxPerS() const;
  bool HasTheSize(const Frame& still);

  acquisition::Device& device_;
  const CameraModel camera_;
  const tracking::PoseSource& poses_;
  const DecisionLimits limits_;
  const int coverage_width_px_;
  static constexpr double kRememberedS = 20;  // of live poses: photographs may be long in coming
  std::deque<LivePose> live_;
  std::deque<Unmeasured> unmeasured_;
  std::vector<double> lags_s_;
  bool said_size_ = false;
  StillCounts counts_;
};

// The intrinsics of a device's photographs: the mode "still" of the calibration that is named or stored for
// the camera. Throws Error that says how to make it.
acquisition::ResolvedCalibration ResolveStillCamera(const acquisition::Device& device,
                                                    const acquisition::IntrinsicsArgs& args);

// A photograph as another camera at the same place would have taken it; what it does not show repeats its
// edge. To build a map of live view's from photographs.
Image AsSeenBy(const CameraModel& camera, const Image& photograph, const CameraModel& photograph_camera);

}  // namespace ulf::coverage
