// One exposure of a bracket, brought to where the reference's pixels are.
#pragma once

#include <opencv2/core.hpp>

#include "core/image/clipped.h"
#include "core/image/sensor_noise.h"

namespace ulf {

// In the reference's pixels (exposure_alignment.h).
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

}  // namespace ulf
