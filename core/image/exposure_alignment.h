// Where another exposure of the same camera shows what a reference picture shows: by the camera's pose at
// each of the two and the depth of the reference's pixels.
#pragma once

#include <opencv2/core.hpp>

#include "core/geometry/camera_model.h"
#include "core/geometry/rigid3.h"
#include "core/image/clipped.h"
#include "core/image/sensor_noise.h"

namespace ulf {

// A photograph as light, with what a merge has to know of it.
struct ExposedLight {
  cv::Mat light;    // CV_32FC3
  cv::Mat clipped;  // CV_8UC3, 255: only a lower bound is known, or noise was cut off at full scale
  SensorNoise noise;
};

// In the reference's pixels.
struct AlignedExposure {
  cv::Mat light;    // CV_32FC3
  cv::Mat seen;     // CV_8UC1, 255 where the exposure shows what the reference's pixel shows
  cv::Mat clipped;  // CV_8UC3
  SensorNoise noise;
  double ratio = 1;          // exposure time times gain, over the reference's
  double misaligned_px = 0;  // how far it may lie off, or is blurred

  // CV_8UC3, 255 where it is seen and not clipped.
  cv::Mat Told() const { return InThreeColors(seen) & ~clipped; }
  // In the reference's terms: over the ratio.
  cv::Vec3f LightAt(int y, int x) const { return light.at<cv::Vec3f>(y, x) * static_cast<float>(1 / ratio); }
  // The variance of that light.
  double VarianceAt(double at_light) const { return noise.VarianceAt(at_light * ratio) / (ratio * ratio); }
};

// `depth`: along the optical axis of `depth_camera`, at the reference's pose: CV_32FC1, world units, above 0
// everywhere. That camera has no distortion and may have another size.
// CV_32FC1 of the picture's size; beyond the edges of `depth` as deep as there. Throws Error for a lens whose
// distortion cannot be inverted in its own picture.
cv::Mat DepthInPicture(const CameraModel& camera, const CameraModel& depth_camera, const cv::Mat& depth);

// Resamples the exposure. Not seen is what lies outside of its picture and what something nearer hides in it.
// `depth`: of the reference's pixels, from DepthInPicture(). `ratio`: as in AlignedExposure.
AlignedExposure AlignExposure(const ExposedLight& exposure, const CameraModel& camera, const cv::Mat& depth,
                              const Rigid3& exposure_from_reference, double ratio);

// The reference itself, or an exposure that is taken to lie where the reference does.
AlignedExposure AsItLies(const ExposedLight& exposure, double ratio);

}  // namespace ulf
