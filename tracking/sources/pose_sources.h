// Makes the sources of poses, each by a function. Their interface is PoseSource (pose_source.h).
#pragma once

#include <filesystem>
#include <memory>
#include <optional>

#include "core/geometry/camera_model.h"
#include "core/geometry/rigid3.h"
#include "core/light_field/light_field.h"
#include "tracking/sources/marker_spec.h"
#include "tracking/sources/pose_stream.h"
#include "tracking/tracker/pose_source.h"
#include "tracking/tracker/tracker.h"
#include "tracking/tracker/tracker_options.h"

namespace ulf::tracking {

// Tracks features (tracker.h).
inline std::unique_ptr<PoseSource> MakeTrackerSource(const CameraModel& camera,
                                                     const TrackerOptions& options) {
  return std::make_unique<Tracker>(camera, options);
}

// Gives the frames' own poses (Frame::known_cam_from_world); a frame without one is lost. Track::speed_px is
// computed for points at the subject's distance, and is unknown without a subject. `metric`: poses in metres.
std::unique_ptr<PoseSource> MakeKnownPoseSource(const CameraModel& camera,
                                                const std::optional<Subject>& subject = {},
                                                bool metric = false);

// Gives poses by markers alone, in metres (marker_locator.h), or by markers and a map of features, which gets
// its world and its unit from the markers and gives poses while they are out of sight.
std::unique_ptr<PoseSource> MakeMarkerSource(const CameraModel& camera, const MarkerSpec& spec);
std::unique_ptr<PoseSource> MakeFeaturesAndMarkersSource(const CameraModel& camera, const MarkerSpec& spec,
                                                         const TrackerOptions& options);

struct TrajectoryOptions {
  double offset_s = 0;     // added to a frame's device time before its pose is looked up
  double max_gap_s = 0.2;  // between poses that are farther apart there is none
  Rigid3 tool_from_cam;    // from the camera to the tool whose poses the file has (hand-eye calibration)
};
// Interpolates between the poses of a TUM file (metres) at the frames' device times. Throws Error if the file
// cannot be read or has no pose.
std::unique_ptr<PoseSource> MakeTrajectorySource(const CameraModel& camera, const std::filesystem::path& file,
                                                 const TrajectoryOptions& options,
                                                 const std::optional<Subject>& subject = {});

// Takes the poses that another program sends (pose_stream.h).
std::unique_ptr<PoseSource> MakeStreamSource(const CameraModel& camera, std::unique_ptr<PoseStream> stream,
                                             const Rigid3& tool_from_cam,
                                             const std::optional<Subject>& subject = {});

// Completes the state of a source's tracks: one for each source, called for every frame.
class PoseContinuity {
 public:
  // Sets `relocalized` and, without a pose, the state: initializing before the first pose, lost after it. A
  // skipped frame does not count as lost.
  void Complete(Track& track) {
    const bool posed = track.cam_from_world.has_value();
    if (!posed) track.state = began_ ? TrackState::kLost : TrackState::kInitializing;
    track.relocalized = posed && began_ && lost_;
    if (!track.skipped) lost_ = !posed;
    began_ = began_ || posed;
  }

 private:
  bool began_ = false, lost_ = false;
};

}  // namespace ulf::tracking
