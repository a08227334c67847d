// Resamples pictures to a camera without distortion whose principal point is exactly in the middle, as
// programs that train radiance fields expect.
#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "core/geometry/camera_model.h"

namespace ulf {

struct Undistortion {
  CameraModel from, to;
  bool is_identity = false;  // the picture needs no change
  bool is_limited = false;   // the limit of 60 degrees cut the picture
  double kept_share = 1;     // of the picture's area
};

// To the same focal lengths: the largest rectangle around the axis that the camera's picture covers
// completely, at most 60 degrees from the axis (there a pixel is stretched to at least four times its area).
// Throws Error that begins with `owner` where the axis is not in the picture.
Undistortion UndistortionOf(const CameraModel& camera, const std::string& owner);
// To one camera with square pixels for all of them: what every camera's largest rectangle holds, with the
// largest of their mean focal lengths. Throws as UndistortionOf(); an owner each.
std::vector<Undistortion> UndistortionsToOne(const std::vector<CameraModel>& cameras,
                                             const std::vector<std::string>& owners);

// For every pixel of the result its place in the source, in the form of cv::remap (CV_32FC1, pixel centres at
// integers).
struct UndistortionMap {
  cv::Mat x, y;
};
UndistortionMap MapOf(const Undistortion& undistortion);

cv::Mat Undistorted(const UndistortionMap& map, const cv::Mat& pixels);
// The same for a mask (0 and 255): a pixel that a masked pixel contributes to is masked.
cv::Mat UndistortedMask(const UndistortionMap& map, const cv::Mat& mask);

}  // namespace ulf
