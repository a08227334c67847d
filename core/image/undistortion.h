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
  bool is_limited = false;   // the limit of 60 degrees from the axis cut the picture
  double kept_share = 1;     // share of the picture's area that the result shows
};

// Keeps the focal lengths and the largest rectangle around the axis that the camera's picture covers
// completely, at most 60 degrees from the axis (beyond it, pixels are stretched to more than four times their
// length). Throws an Error that begins with `owner`, the view's or the camera's name, if the axis is not in
// the picture or fewer than 16 px are left.
Undistortion UndistortionOf(const CameraModel& camera, const std::string& owner);
// Uses one camera with square pixels for all: the rectangle that fits into every camera's largest one, with
// the largest mean focal length. `owners` has a name for each camera. Throws as UndistortionOf() does.
std::vector<Undistortion> UndistortionsToOne(const std::vector<CameraModel>& cameras,
                                             const std::vector<std::string>& owners);

// A map of cv::remap: the place of each pixel of `to` in the picture of `from`, pixel centres at integers.
struct UndistortionMap {
  cv::Mat x, y;  // CV_32FC1
};
UndistortionMap MapOf(const Undistortion& undistortion);

cv::Mat Undistorted(const UndistortionMap& map, const cv::Mat& pixels);
// The same for a mask (0: masked, else used): a pixel is masked if one of the four around its place is.
cv::Mat UndistortedMask(const UndistortionMap& map, const cv::Mat& mask);

}  // namespace ulf
