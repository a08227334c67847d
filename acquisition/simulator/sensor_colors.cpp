#include "acquisition/simulator/sensor_colors.h"

#include <Eigen/LU>
#include <cmath>

namespace ulf::acquisition {
namespace {

constexpr double kDaylightK = 6504;

double Planck(double nanometres, double kelvin) {
  constexpr double kSecondRadiationConstant = 1.438777e7;  // nm K
  return 1 / std::expm1(kSecondRadiationConstant / (nanometres * kelvin));
}

}  // namespace

SensorColors SensorColors::FromUri(const DeviceUri& uri) {
  SensorColors colors;
  colors.lamp_k = uri.Number("lamp_k", colors.lamp_k, 1500, 20000);
  colors.crosstalk = uri.Number("crosstalk", colors.crosstalk, 0, 0.4);
  return colors;
}

Eigen::Matrix3d SensorColors::CameraFromSrgb() const {
  const auto beside_daylight = [&](double nanometres) {
    return Planck(nanometres, lamp_k) / Planck(nanometres, kDaylightK);
  };
  const Eigen::Vector3d lamp(beside_daylight(600), beside_daylight(540), beside_daylight(450));
  Eigen::Matrix3d neighbours;
  neighbours << 0, 0.8, 0.2, 0.5, 0, 0.5, 0.1, 0.9, 0;
  const Eigen::Matrix3d filters = (1 - crosstalk) * Eigen::Matrix3d::Identity() + crosstalk * neighbours;
  return filters * (lamp / lamp[1]).asDiagonal();
}

Eigen::Vector3d SensorColors::WhiteBalance() const {
  const Eigen::Vector3d white = CameraFromSrgb() * Eigen::Vector3d::Ones();
  return white[1] * white.cwiseInverse();
}

Eigen::Matrix3d SensorColors::SrgbFromBalanced() const {
  const Eigen::Matrix3d balanced = WhiteBalance().asDiagonal() * CameraFromSrgb();
  return (balanced * Eigen::Vector3d::Ones())[1] * balanced.inverse();
}

}  // namespace ulf::acquisition
