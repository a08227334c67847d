// The velocity about each frame's rows, from frame to frame: what a tracker needs to follow a camera with a
// rolling shutter (rolling_shutter.h).
//
// A frame's rows show its velocity relative to the map, tremor and all, but a map stretched along the columns
// shows a wrong one just as well. Velocities between frames know nothing of tremor, but are right on average.
// So what the rows show is used, less the mean of late by which it differs from the velocity between the
// frames before and after.
#pragma once

#include <optional>
#include <span>

#include "tracking/estimation/rolling_shutter.h"
#include "tracking/tracker/frame_locator.h"
#include "tracking/tracker/initializer.h"

namespace ulf::tracking {

class RowMotion {
 public:
  RowMotion(const CameraModel& camera, double readout_s) : camera_(camera), readout_s_(readout_s) {}

  double readout_s() const { return readout_s_; }
  bool rolls() const { return readout_s_ != 0; }
  void SetReadout(double readout_s) { readout_s_ = readout_s; }
  void Forget();             // the frames before: the next one follows none
  void Scale(double scale);  // lengths, from now on

  // The two views of a start, each with the velocity that its features'
  // motion in the image shows, and, of a rolling shutter, brought to its time by it.
  void AtStart(TwoViewStart& start);
  // The frame as it would be under the last velocity, to be looked for at `predicted`.
  void Expect(TrackedImage& image, const Rigid3& predicted,
              std::span<const Eigen::Vector3d> points_in_world) const;
  // The frame was found: its pose, its rows' velocity and its picture's pose, and all of it brought to its
  // time. `between`: the velocity since the frame before, if there was one. `with_corners`: the map's world
  // is that of what the frame shows of a given one.
  void Settle(TrackedImage& image, FramePose& located, const std::optional<Twist>& between,
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
  Twist off_ = Twist::Zero();  // by rows less between frames, of late
  int offs_ = 0;
};

}  // namespace ulf::tracking
