// Estimates the noise of a sensor from photographs that it took: shot noise grows with the light, read noise
// and rounding are constant. Both depend on the sensor and its gain, not on the exposure, so all photographs
// at one gain are used together: long exposures of a bracket show the noise of dark numbers, which fill short
// ones.
//
// Smooth areas are used, with a second difference that light which rises evenly does not change (Immerkaer
// 1996, "Fast noise variance estimation"). Numbers at the end of their range are left out: noise is cut off
// there.
//
// Light is a share of full scale, above black.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "core/image/image.h"

namespace ulf {

// The variance of a photograph's light is per_light * light + floor.
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
  // `light` is CV_32FC3, made of `image`; `clipped` is CV_8UC1 of its size, 255 where light is not known.
  void Add(const Image& image, const cv::Mat& light, const cv::Mat& clipped);
  // The result is never below rounding noise. If nothing is smooth enough, or bright enough to show noise on
  // both sides, the noise is assumed to be cut off at its mean.
  SensorNoise Fit() const;

 private:
  std::vector<NoiseOfLight> blocks_;
  std::vector<double> dark_light_;  // light of blocks whose noise is cut off at black
  SensorNoise rounding_;
};

}  // namespace ulf
