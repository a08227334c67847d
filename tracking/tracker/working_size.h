// The size that pictures are tracked at, and the way between its pixels and those of the pictures as they
// come.
//
// How large a corner or a patch is, how many features a frame gets and how far matches are looked for are
// numbers of pixels, right for pictures of about the working size, whatever the lens resolves. Larger ones
// are reduced, each pixel the mean of the area that it covers; smaller ones are tracked as they are.
//
// Frames: both sizes show the same picture from edge to edge, pixel centres at integer + 0.5. So image points
// and the camera model scale by the ratio of the sizes alone (which differs a little between the axes where a
// size had to be rounded), distortion stays, and poses, angles and world lengths are the same in both.
// Unit: "working" is pixels of the size that is tracked, "original" those of the pictures as they come.
//
// For the tracker's front door (tracker.h) alone: everything inside of it is in working pixels, whatever goes
// in or comes out in original ones.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <opencv2/core.hpp>

#include "core/geometry/camera_model.h"
#include "tracking/map/fiducial_observation.h"

namespace ulf::tracking {

class WorkingSize {
 public:
  // At most `max_side_px` on the longer side; 0: pictures are tracked as they come.
  WorkingSize(const CameraModel& original, int max_side_px);

  const CameraModel& original() const { return original_; }
  const CameraModel& working() const { return working_; }
  bool IsReduced() const { return working_.width != original_.width || working_.height != original_.height; }

  // A picture (of any type) of the original size at the working one; itself where they are the same.
  cv::Mat Reduced(const cv::Mat& original) const;
  FiducialObservation Reduced(FiducialObservation original) const;

  Eigen::Vector2d ToOriginal(const Eigen::Vector2d& working) const;
  // A distance in the image, by the mean of the two axes.
  double ToOriginal(double working_px) const;
  // Of a key that says what something belongs to: another one where it is in pixels of a reduced size.
  std::uint64_t KeyAtWorkingSize(std::uint64_t key) const;

 private:
  Eigen::Vector2d WorkingByOriginal() const;
  CameraModel original_, working_;
};

}  // namespace ulf::tracking
