// From light to numbers, as an industrial image sensor does it: photo-electrons proportional to radiance,
// exposure and the pixel's area; shot noise (Gaussian of the signal's variance, which Poisson's law is at
// these counts), read noise, gain, a linear 8-bit converter that clips. Left out: dark current, fixed
// pattern, blooming, black level.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>
#include <string>

#include "acquisition/image.h"

namespace ulf {

// GenICam's names: Mono8, BayerRG8, RGB8 (B, G, R in an ulf::Image, as always).
enum class SensorFormat { kMono8, kBayerRg8, kRgb8 };
std::optional<SensorFormat> SensorFormatByName(const std::string& name);  // any case: "rgb8", "BayerRG8"
const char* NameOf(SensorFormat format);

struct SensorOptions {
  double reference_exposure_s = 0.005;  // radiance 1 for this long fills the well
  double full_well_electrons = 10000;   // full scale at gain 1
  double read_noise_electrons = 8;
  bool noise = true;
};

struct SensorShot {
  double exposure_s = 0.005;
  double gain = 1;  // linear
  SensorFormat format = SensorFormat::kRgb8;
  std::uint64_t noise_seed = 0;
};

// `radiance`: CV_32FC4, linear B, G, R. The same seed gives the same noise.
Image Expose(const cv::Mat& radiance, const SensorOptions& options, const SensorShot& shot);

}  // namespace ulf
