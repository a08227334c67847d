// Estimates the camera's velocity while each frame's rows are read, so that a tracker can follow a camera
// with a rolling shutter (rolling_shutter.h).
//
// A frame's rows show its velocity relative to the map, tremor included, but a map that is stretched along
// the columns shows a wrong velocity. Velocities between frames miss the tremor, but are right on average. So
// the rows' velocity is used, minus the recent mean of its difference to the velocity between the frames
// before and after.
#pragma once

#include <optional>
#include <span>

#include "tracking/estimation/rolling_shutter.h"
#include "tracking/map/map_matching.h"
#include "tracking/map/tracked_image.h"

namespace ulf::tracking {

class RowMotion {
 public:
  RowMotion(const CameraModel& camera, double readout_s) : camera_(camera), readout_s_(readout_s) {}

  double readout_s() const { return readout_s_; }
  bool rolls() const { return readout_s_ != 0; }
  void SetReadout(double readout_s) { readout_s_ = readout_s; }
  void SetCamera(const CameraModel& camera) { camera_ = camera; }  // another lens, the same image size
  void Forget();                                                   // the next frame follows no other
  void Scale(double scale);  // the unit of length changes by this factor

  // Estimates the velocities of a start's two views from their features' motion in the image and, with a
  // rolling shutter, removes the rows' motion from the views.
  void InitializeFrom(TwoViewStart& start);
  // Removes the rows' motion under the last velocity from a frame that is expected at `predicted`.
  void RemoveExpectedShift(TrackedImage& image, const Rigid3& predicted,
                           std::span<const Eigen::Vector3d> points_in_world) const;
  // Refines the pose of a located frame with its rows' velocity, sets the image's pose, and removes the rows'
  // motion from image and matches. `between`: the velocity since the frame before, where that is known.
  // `with_corners`: the map's world is the one in which the frame's fiducials are given.
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
