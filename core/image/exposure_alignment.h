// Aligns another exposure of the same camera to a reference exposure of a bracket, by the camera's poses at
// both and the depth of the reference's pixels.
#pragma once

#include <opencv2/core.hpp>

#include "core/geometry/camera_model.h"
#include "core/geometry/rigid3.h"
#include "core/image/clipped.h"
#include "core/image/sensor_noise.h"

namespace ulf {

// A photograph as linear light, with its clipped pixels and noise.
struct ExposedLight {
  cv::Mat light;    // CV_32FC3
  cv::Mat clipped;  // CV_8UC3, 255 where only a lower bound is known, or noise was cut off at full scale
  SensorNoise noise;
};

// An exposure resampled to the reference's pixels.
struct AlignedExposure {
  cv::Mat light;    // CV_32FC3
  cv::Mat seen;     // CV_8UC1, 255 where the exposure shows what the reference's pixel shows
  cv::Mat clipped;  // CV_8UC3
  SensorNoise noise;
  double ratio = 1;          // exposure time times gain, over the reference's
  double misaligned_px = 0;  // how far it may be misaligned or blurred; the caller's estimate

  // Returns CV_8UC3, 255 where the pixel is seen and its colour not clipped.
  cv::Mat Usable() const { return InThreeColors(seen) & ~clipped; }
  // Returns the light divided by the ratio, which is comparable to the reference's.
  cv::Vec3f LightAt(int y, int x) const { return light.at<cv::Vec3f>(y, x) * static_cast<float>(1 / ratio); }
  // Returns the variance of that light.
  double VarianceAt(double at_light) const { return noise.VarianceAt(at_light * ratio) / (ratio * ratio); }
};

// Returns the depth at each pixel of `camera`, CV_32FC1, taken from `depth`: CV_32FC1, depth along the
// optical axis in world units, above 0 everywhere, as `depth_camera` sees it from the reference's pose. That
// camera has no distortion and may have another size; beyond its edges the depth of the edge is used. Throws
// Error if the distortion of `camera` cannot be inverted somewhere in its picture.
cv::Mat DepthInPicture(const CameraModel& camera, const CameraModel& depth_camera, const cv::Mat& depth);

// Resamples the exposure. Pixels outside of its picture, and those that something nearer hides in it, are not
// seen. `depth` is of DepthInPicture(), `ratio` as in AlignedExposure. Throws as DepthInPicture() does.
AlignedExposure AlignExposure(const ExposedLight& exposure, const CameraModel& camera, const cv::Mat& depth,
                              const Rigid3& exposure_from_reference, double ratio);

// Uses an exposure without resampling: the reference itself, or one that is assumed to be aligned with it.
AlignedExposure WithoutAlignment(const ExposedLight& exposure, double ratio);

}  // namespace ulf
