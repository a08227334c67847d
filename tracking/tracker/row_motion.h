// Estimates the camera's velocity while each frame's rows are read, so that a tracker can follow a camera
// with a rolling shutter (rolling_shutter.h).
//
// A frame's rows show its velocity relative to the map, tremor included, but a map that is stretched along
// the columns shows a wrong velocity. Velocities between frames miss the tremor, but are right on average. So
// the velocity that the rows show is used, minus the recent mean of its difference from the velocity between
// the frames before and after.
#pragma once

#include <optional>
#include <span>

#include "tracking/estimation/rolling_shutter.h"
#include "tracking/map/map_matching.h"
#include "tracking/map/tracked_image.h"

namespace ulf::tracking {

class RowMotion {
 public:
  // `readout_s` is the time from the first row to the last; 0: the shutter is global.
  RowMotion(const CameraModel& camera, double readout_s) : camera_(camera), readout_s_(readout_s) {}

  double readout_s() const { return readout_s_; }
  bool rolls() const { return readout_s_ != 0; }
  void SetReadout(double readout_s) { readout_s_ = readout_s; }
  void SetCamera(const CameraModel& camera) { camera_ = camera; }  // another lens, the same image size
  void Forget();             // call it when the next frame does not follow the last one
  void Scale(double scale);  // multiplies lengths, after the map's unit has changed

  // Sets the velocities of a start's two views from their features' motion in the image and, with a rolling
  // shutter, removes its shift from the views.
  void InitializeFrom(TwoViewStart& start);
  // Removes the shift under the last velocity from a frame whose pose is expected to be `predicted`; the
  // points give depths. Does nothing without a last velocity or points.
  void RemoveExpectedShift(TrackedImage& image, const Rigid3& predicted,
                           std::span<const Eigen::Vector3d> points_in_world) const;
  // Refines the middle row's pose and the velocity of a located frame, sets FramePose::picture_from_cam, and
  // removes the shift from image and matches. `between` is the velocity since the frame before, if known;
  // `with_corners` says that the map's world is the one in which the frame's fiducials are given.
  void RefineWithRows(TrackedImage& image, FramePose& frame_pose, const std::optional<Twist>& between,
                      bool with_corners);

 private:
  void GiveRows(TrackedImage& image, const Twist& velocity, std::span<const DepthField::Sample> depths) const;
  CameraModel camera_;
  double readout_s_;
  struct Before {
    Twist by_rows, between;
  };
  std::optional<Twist> velocity_;  // of the last frame
  std::optional<Before> before_;
  Twist mean_difference_ = Twist::Zero();  // recent mean of the rows' velocity minus the one between frames
  int differences_ = 0;
};

}  // namespace ulf::tracking
