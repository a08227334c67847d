// Models an industrial image sensor: photo-electrons proportional to radiance and exposure; shot noise
// (Gaussian with the variance of the Poisson distribution), read noise, gain, a linear converter of 8 to 16
// bits that clips (see EMVA 1288). It has no dark current, fixed pattern, blooming or black level.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>
#include <string>

#include "acquisition/device/device.h"
#include "core/frames/pixel_format.h"
#include "core/image/image.h"

namespace ulf::acquisition {

// The pixel formats that `ulf simulate` offers, named as in GenICam PFNC. For `sim:`, which sends no packets,
// Mono12 and Mono12p are the same.
enum class SensorFormat {
  kMono8,
  kMono10,
  kMono10p,
  kMono12,
  kMono12p,
  kMono16,
  kBayerGr8,
  kBayerRg8,
  kBayerGb8,
  kBayerBg8,
  kBayerGr12,
  kBayerRg12,
  kBayerGb12,
  kBayerBg12,
  kBayerGr12p,
  kBayerRg12p,
  kBayerGb12p,
  kBayerBg12p,
  kRgb8,
  kBgr8,
};
std::optional<SensorFormat> SensorFormatByName(const std::string& name);  // any case: "rgb8", "BayerRG8"
std::optional<SensorFormat> SensorFormatByCode(std::uint32_t pfnc);
const PixelFormat& PixelsOf(SensorFormat format);
// Returns the format that a URI asks for, or none. Throws Refusal that lists the formats.
std::optional<SensorFormat> SensorFormatOf(const DeviceUri& uri);

inline constexpr double kReferenceExposure_s = 0.005;  // radiance 1 fills the well in this time
inline constexpr double kFullWellElectrons = 10000;    // full scale at gain 1
inline constexpr double kReadNoiseElectrons = 8;

struct SensorShot {
  double exposure_s = 0.005;
  double gain = 1;  // linear
  SensorFormat format = SensorFormat::kRgb8;
  std::uint64_t noise_seed = 0;
  bool noise = true;
};

// Converts radiance, CV_32FC4 of linear B, G, R, to an image. The same seed gives the same noise. Values of
// more than 8 bits are scaled to 16 bits (pixel_format.h).
Image Expose(const cv::Mat& radiance, const SensorShot& shot);

// The colour response of a simulated sensor: the lamp's colour, and channels whose filters overlap.
//
// The scenes' light is linear sRGB under white D65. A lamp of another colour temperature multiplies its
// channels (Planck's law at 600, 540 and 450 nm, beside that of 6504 K, green left as it is); then each
// channel takes a share of its neighbours'. Both are linear, so that the profile that undoes them is known.
struct SensorColors {
  double lamp_k = 6504;
  double crosstalk = 0;  // share of a channel's signal that is its neighbours' light, 0 to 0.4

  // Reads lamp_k and crosstalk of a URI. Throws Refusal for values out of range.
  static SensorColors FromUri(const DeviceUri& uri);

  // Returns the sensor's R G B for linear sRGB.
  Eigen::Matrix3d CameraFromSrgb() const;
  // Return what a profile must find: factors of R G B, green 1, and the matrix, whose rows sum to one.
  Eigen::Vector3d WhiteBalance() const;
  Eigen::Matrix3d SrgbFromBalanced() const;
};

}  // namespace ulf::acquisition
