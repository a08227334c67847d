// Estimates the noise of a sensor from photographs that it took: shot noise grows with the light, read noise
// and rounding are constant. Both depend on the sensor and its gain, not on the exposure time, so all
// photographs at one gain are used together: the long exposures of a bracket contribute the noise at values
// that are dark in the short ones.
//
// Smooth areas are measured by second differences, which cancel a linear gradient (Immerkaer 1996, "Fast
// noise variance estimation"). Blocks with values at the ends of the range, where noise is cut off, are left
// out. Light is a share of full scale, 0 at the black level; variances are squares of such shares.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "core/image/image.h"

namespace ulf {

// The variance of a photograph's light is per_light * light + floor.
struct SensorNoise {
  double per_light = 0;  // of shot noise: one over the electrons at full scale
  double floor = 0;      // of read noise and rounding
  double VarianceAt(double light) const { return per_light * (light > 0 ? light : 0) + floor; }
};

// The mean and the noise variance of one block of pixels in one colour.
struct NoiseOfLight {
  double light = 0, variance = 0;
};

// Collects blocks of photographs at one gain, and fits the noise to them.
class NoiseSamples {
 public:
  // `light` is CV_32FC3, made of `image`; `clipped` is CV_8UC1 of its size, 255 where light is not known.
  void Add(const Image& image, const cv::Mat& light, const cv::Mat& clipped);
  // Returns the noise, never below that of rounding. If all blocks are clipped or at black, black is taken
  // for the mean of the noise, whose lower half is cut off.
  SensorNoise Fit() const;

 private:
  std::vector<NoiseOfLight> blocks_;
  std::vector<double> dark_light_;  // light of blocks whose noise is cut off at black
  SensorNoise rounding_;
};

}  // namespace ulf
