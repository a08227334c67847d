// Defines the size at which images are tracked, and converts between its pixels ("working") and those of the
// images as they come ("original").
//
// The size of corners and patches, the number of features and the search radii are numbers of pixels that
// suit images of about the working size. Larger images are reduced; smaller ones are tracked as they are.
// Both sizes show the same image from edge to edge, pixel centres at integer + 0.5. So image points and the
// camera model scale by the ratio of the sizes (which differs a little between the axes if a size had to be
// rounded); distortion, poses, angles and world lengths are the same in both.
//
// Only tracker*.cpp convert: everything inside the tracker is in working pixels, everything that goes in or
// comes out is in original ones.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <opencv2/core.hpp>
#include <string>

#include "core/geometry/camera_model.h"
#include "tracking/map/fiducial_observation.h"

namespace ulf::tracking {

// Throws Error if an image has another size than its camera. `what` begins the message, `way_out` ends it.
void RequireSize(const std::string& what, const cv::Size& size, const CameraModel& camera,
                 const char* way_out = "calibrate for this size");

class WorkingSize {
 public:
  // `max_side_px` is the largest longer side; 0: images are tracked as they come.
  WorkingSize(const CameraModel& original, int max_side_px);

  // Replaces the lens by another of the same image size; `working` is in working pixels.
  void SetWorking(const CameraModel& working);
  const CameraModel& original() const { return original_; }
  const CameraModel& working() const { return working_; }
  bool IsReduced() const { return working_.width != original_.width || working_.height != original_.height; }

  // Reduces an image (of any type) of the original size; returns it as it is if the sizes are the same.
  cv::Mat Reduced(const cv::Mat& original) const;
  FiducialObservation Reduced(const FiducialObservation& original) const;

  Eigen::Vector2d ToOriginal(const Eigen::Vector2d& working) const;
  // Converts a distance in the image, by the mean of the two axes.
  double ToOriginal(double working_px) const;
  // Returns the key (map_file.h) of what is in working pixels: `key`, mixed with a reduced size.
  std::uint64_t KeyAtWorkingSize(std::uint64_t key) const;

 private:
  Eigen::Vector2d WorkingByOriginal() const;
  CameraModel original_, working_;
};

}  // namespace ulf::tracking
