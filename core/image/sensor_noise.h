// The noise of a sensor, measured in photographs that it took: shot noise grows with the light, read noise
// and rounding are always there. Both belong to the sensor at a gain and not to an exposure, so that all
// photographs at one gain tell them together: the long exposures of a bracket the noise of dark numbers, of
// which short ones are full.
//
// Measured on what is smooth, by a second difference that light which rises evenly does not change (Immerkaer
// 1996, "Fast noise variance estimation"). Numbers at the end of their range are left out: noise is cut off
// there.
//
// Light is a share of full scale, above black.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "core/image/image.h"

namespace ulf {

// The variance of a photograph's light: per_light * light + floor.
struct SensorNoise {
  double per_light = 0;  // shot noise: gain over the full well
  double floor = 0;      // read noise and rounding
  double VarianceAt(double light) const { return per_light * (light > 0 ? light : 0) + floor; }
};

struct NoiseOfLight {
  double light = 0, variance = 0;
};

class NoiseSamples {
 public:
  // `light`: CV_32FC3, of `image`; `clipped`: CV_8UC1 of its size, 255 where light is not known.
  void Add(const Image& image, const cv::Mat& light, const cv::Mat& clipped);
  // Never below what rounding brings. Where nothing is smooth enough, or bright enough to show its noise
  // whole, it is what noise that was cut off in the middle looks like.
  SensorNoise Fit() const;

 private:
  std::vector<NoiseOfLight> blocks_;
  std::vector<double> dark_light_;  // of blocks whose noise is cut off at black
  SensorNoise rounding_;
};

}  // namespace ulf
