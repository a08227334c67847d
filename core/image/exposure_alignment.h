// Where another exposure of the same camera shows what a reference picture shows: by the camera's pose at each of the two
// and the depth of the reference's pixels.
#pragma once

#include <opencv2/core.hpp>

#include "core/geometry/camera_model.h"
#include "core/geometry/rigid3.h"
#include "core/image/aligned_exposure.h"

namespace ulf {

// `depth`: along the optical axis of `depth_camera`, at the reference's pose: CV_32FC1, world units, above 0
// everywhere. That camera has no distortion and may have another size.
// CV_32FC1 of the picture's size; beyond the edges of `depth` as deep as there. Throws Error for a lens whose distortion
// cannot be inverted in its own picture.
cv::Mat DepthInPicture(const CameraModel& camera, const CameraModel& depth_camera, const cv::Mat& depth);

// Resamples the exposure. Not seen is what lies outside of its picture and what something nearer hides in it.
// `depth`: of the reference's pixels, from DepthInPicture(). `ratio`: as in AlignedExposure.
AlignedExposure AlignExposure(const ExposedLight& exposure, const CameraModel& camera, const cv::Mat& depth,
                              const Rigid3& exposure_from_reference, double ratio);

// The reference itself, or an exposure that is taken to lie where the reference does.
AlignedExposure AsItLies(const ExposedLight& exposure, double ratio);

}  // namespace ulf
