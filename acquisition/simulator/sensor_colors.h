// What a simulated sensor makes of colours: the lamp's colour, and channels whose filters overlap.
//
// The scenes' light is linear sRGB under white D65. A lamp of another colour temperature multiplies its channels (Planck's
// law at 600, 540 and 450 nm, beside that of 6504 K, green left as it is); then each channel takes a share of its
// neighbours'. Both are linear, so that the colour profile that undoes them is known exactly.
#pragma once

#include <Eigen/Core>

#include "acquisition/device/device.h"

namespace ulf::acquisition {

struct SensorColors {
  double lamp_k = 6504;
  double crosstalk = 0;  // share of a channel that its neighbours have, 0 to 0.4

  // Of a URI: lamp_k, crosstalk. Throws Refusal for values out of range.
  static SensorColors FromUri(const DeviceUri& uri);

  // R G B.
  Eigen::Matrix3d CameraFromSrgb() const;
  // What a profile must find: factors of R G B, green 1, and the matrix of balanced light, whose rows sum to one.
  Eigen::Vector3d WhiteBalance() const;
  Eigen::Matrix3d SrgbFromBalanced() const;
};

}  // namespace ulf::acquisition
