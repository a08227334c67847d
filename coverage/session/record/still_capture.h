// Takes photographs with a tethered camera: live frames are tracked and never recorded; where coverage needs
// a view, the capture requests a photograph, one at a time, and judges it when it arrives.
//
// Between the request and the shutter the hand moves on. So the photograph gets a pose of its own against the
// tracker's map, with the intrinsics of photographs. It is recorded when it passes the tests of a live frame:
// it shows the whole subject, shows something that no recorded view shows, and is well exposed and sharp.
// Every other photograph, also one that was released on the camera's body, is kept in unposed/.
//
// No protocol reports the shutter's lag, from the request to the exposure. It is measured: the place on the
// live trajectory that is nearest to the photograph's own pose tells when it was taken, on the clock of the
// live frames (which includes live view's own delay). Photographs that were requested while the hand stood
// still tell nothing; the median of the others predicts later ones, unless the device was given a lag.
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <vector>

#include "acquisition/calibration/intrinsics.h"
#include "acquisition/device/device.h"
#include "coverage/bound/view_decision.h"
#include "tracking/tracker/pose_source.h"

namespace ulf::coverage {

struct StillCounts {
  std::uint64_t asked = 0;    // requests that the device accepted
  std::uint64_t arrived = 0;  // also those released on the body
  std::uint64_t recorded = 0;
  std::uint64_t not_needed = 0;  // with a pose, but covered by then, cropped, or of poor quality: in unposed/
  std::uint64_t without_pose = 0;  // in unposed/
  std::uint64_t lags = 0;          // measured
  std::optional<double> lag_s;     // their median
};

// A live frame's pose at its time.
struct LivePose {
  double time_s = 0;  // the device's
  Rigid3 cam_from_world;
  double speed_px = 0;  // motion since the frame before, in photograph pixels
};

// Returns when the trajectory, in the order of time, passed `cam_from_world`, interpolated between its poses.
// Poses are compared by the angle that a subject `distance` away moves in the image. Returns none where the
// pose fits two times more than 50 ms apart (the hand stood still, or passed twice), or is at either end.
std::optional<double> TimeOnTrajectory(std::span<const LivePose> trajectory, const Rigid3& cam_from_world,
                                       double distance);

struct StillVerdict {
  Decision decision;                     // kRecorded: to be recorded; anything else: to be kept in unposed/
  std::optional<tracking::Track> track;  // where it was taken; none when that was not found
  std::optional<double> distance;        // from there to the subject, if there is one
};

class StillCapture {
 public:
  // `camera`: of photographs. `device` and `poses` outlive it.
  StillCapture(acquisition::Device& device, const CameraModel& camera, const tracking::PoseSource& poses,
               int coverage_width_px);

  const CameraModel& camera() const { return camera_; }
  const StillCounts& counts() const { return counts_; }

  // Call it for every live frame: photographs are searched on their trajectory.
  void Follow(const Frame& live, const tracking::Track& track);
  void RequestStill();  // the device ignores it while a photograph is on its way
  // Finds the photograph's pose and decides about it. `map`: null while there is no subject; it is then not
  // to be recorded.
  StillVerdict Judge(const Frame& still, const CoverageMap* map) const;
  // Returns where the photograph was taken; none when that was not found.
  std::optional<tracking::Track> Find(const Frame& still) const;
  // Call it once for every photograph that arrived. Note() also takes what Judge() said of it, after it was
  // recorded or kept: the photograph's lag is measured later.
  void NoteArrived(const Frame& still, bool is_found);
  void Note(const Frame& still, const StillVerdict& verdict);

 private:
  // A photograph whose lag is measured later.
  struct Unmeasured {
    double requested_s = 0, judged_s = 0;
    Rigid3 cam_from_world;
    double distance = 0;
  };
  double ExpectedTime(const Frame& still) const;
  void MeasureLags();
  std::optional<Rigid3> LivePoseAt(double time_s) const;
  double SpeedPxPerS() const;
  bool HasExpectedSize(const Frame& still) const;

  acquisition::Device& device_;
  const CameraModel camera_;
  const tracking::PoseSource& poses_;
  const int coverage_width_px_;
  std::deque<LivePose> live_;
  std::deque<Unmeasured> unmeasured_;
  std::vector<double> lags_s_;
  bool said_size_ = false;
  StillCounts counts_;
};

// Returns the intrinsics of a device's photographs: the mode "still" of the calibration that is named or
// stored for the camera. Throws Error that says how to make it.
acquisition::ResolvedCalibration ResolveStillCamera(const acquisition::Device& device,
                                                    const acquisition::IntrinsicsArgs& args);

// Resamples a photograph as another camera at the same pose would have taken it, to build live view's map
// from photographs; outside of what the photograph shows, its edge is repeated.
Image AsSeenBy(const CameraModel& camera, const Image& photograph, const CameraModel& photograph_camera);

}  // namespace ulf::coverage
