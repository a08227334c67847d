// Pictures as a camera without distortion would have taken them from the same place, its principal point
// exactly in the middle: what trainers of radiance fields ask for.
#pragma once

#include <opencv2/core.hpp>
#include <string>

#include "core/geometry/camera_model.h"

namespace ulf {

struct Undistortion {
  CameraModel from, to;      // the same focal lengths
  bool is_identity = false;  // the picture stays as it is
  bool is_limited = false;   // more could be seen, stretched beyond use
  double kept_share = 1;     // of the picture's area
};

// The largest picture around the axis that the camera's own covers to the last pixel, no farther than 60
// degrees from the axis, where a pixel is stretched to four times its area and more. Throws Error naming
// `owner` where its middle is not in the picture.
Undistortion UndistortionOf(const CameraModel& camera, const std::string& owner);

// Pixels of the source for every pixel of the result, as cv::remap takes them.
struct UndistortionMap {
  cv::Mat x, y;
};
UndistortionMap MapOf(const Undistortion& undistortion);

cv::Mat Undistorted(const UndistortionMap& map, const cv::Mat& pixels);
// Of a mask: what touches a masked pixel is masked; 0 and 255 only.
cv::Mat UndistortedMask(const UndistortionMap& map, const cv::Mat& mask);

}  // namespace ulf
