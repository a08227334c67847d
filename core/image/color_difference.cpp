#include "core/image/color_difference.h"

#include <Eigen/LU>
#include <cmath>

namespace ulf {
namespace {

// Converts linear sRGB to XYZ of D50: sRGB's matrix (IEC 61966-2-1), adapted by Bradford's.
const Eigen::Matrix3d& XyzFromSrgb() {
  static const Eigen::Matrix3d matrix = [] {
    Eigen::Matrix3d srgb, cone;
    srgb << 0.4124564, 0.3575761, 0.1804375, 0.2126729, 0.7151522, 0.0721750, 0.0193339, 0.1191920, 0.9503041;
    cone << 0.8951, 0.2664, -0.1614, -0.7502, 1.7135, 0.0367, 0.0389, -0.0685, 1.0296;
    const Eigen::Vector3d d65 = srgb * Eigen::Vector3d::Ones(), d50(0.96422, 1.0, 0.82521);
    const Eigen::Vector3d gains = (cone * d50).cwiseQuotient(cone * d65);
    return Eigen::Matrix3d(cone.inverse() * gains.asDiagonal() * cone * srgb);
  }();
  return matrix;
}

constexpr double kLinearBelow = 6.0 / 29;  // of the cube root

double Root(double t) {
  return t > kLinearBelow * kLinearBelow * kLinearBelow ? std::cbrt(t)
                                                        : t / (3 * kLinearBelow * kLinearBelow) + 4.0 / 29;
}

double Cube(double root) {
  return root > kLinearBelow ? root * root * root : 3 * kLinearBelow * kLinearBelow * (root - 4.0 / 29);
}

// Returns degrees, 0 to 360; 0 without a hue.
double Hue(double a, double b) {
  if (a == 0 && b == 0) return 0;
  const double degrees = std::atan2(b, a) * 180 / M_PI;
  return degrees < 0 ? degrees + 360 : degrees;
}

double CosDegrees(double degrees) { return std::cos(degrees * M_PI / 180); }

}  // namespace

Eigen::Vector3d LabFromLinearSrgb(const Eigen::Vector3d& rgb) {
  const Eigen::Vector3d white = XyzFromSrgb() * Eigen::Vector3d::Ones();
  const Eigen::Vector3d roots = (XyzFromSrgb() * rgb).cwiseQuotient(white).unaryExpr(&Root);
  return {116 * roots.y() - 16, 500 * (roots.x() - roots.y()), 200 * (roots.y() - roots.z())};
}

Eigen::Vector3d LinearSrgbFromLab(const Eigen::Vector3d& lab) {
  const double y = (lab[0] + 16) / 116;
  const Eigen::Vector3d white = XyzFromSrgb() * Eigen::Vector3d::Ones();
  const Eigen::Vector3d xyz(Cube(y + lab[1] / 500), Cube(y), Cube(y - lab[2] / 200));
  return XyzFromSrgb().inverse() * xyz.cwiseProduct(white);
}

// The names are those of the paper.
double ColorDifference2000(const Eigen::Vector3d& lab_a, const Eigen::Vector3d& lab_b) {
  const auto seventh = [](double c) {
    return std::sqrt(std::pow(c, 7) / (std::pow(c, 7) + std::pow(25.0, 7)));
  };
  const double mean_c = 0.5 * (std::hypot(lab_a[1], lab_a[2]) + std::hypot(lab_b[1], lab_b[2]));
  const double g = 0.5 * (1 - seventh(mean_c));
  const double a1 = (1 + g) * lab_a[1], a2 = (1 + g) * lab_b[1];
  const double c1 = std::hypot(a1, lab_a[2]), c2 = std::hypot(a2, lab_b[2]);
  const double h1 = Hue(a1, lab_a[2]), h2 = Hue(a2, lab_b[2]);
  const bool grey = c1 * c2 == 0;
  double dh = grey ? 0 : h2 - h1;
  if (dh > 180) dh -= 360;
  if (dh < -180) dh += 360;
  const double delta_l = lab_b[0] - lab_a[0], delta_c = c2 - c1;
  const double delta_h = 2 * std::sqrt(c1 * c2) * std::sin(0.5 * dh * M_PI / 180);
  const double mean_l = 0.5 * (lab_a[0] + lab_b[0]), mean_c_prime = 0.5 * (c1 + c2);
  double mean_h = h1 + h2;
  if (!grey) {
    if (std::abs(h1 - h2) > 180) mean_h += mean_h < 360 ? 360 : -360;
    mean_h *= 0.5;
  }
  const double t = 1 - 0.17 * CosDegrees(mean_h - 30) + 0.24 * CosDegrees(2 * mean_h) +
                   0.32 * CosDegrees(3 * mean_h + 6) - 0.20 * CosDegrees(4 * mean_h - 63);
  const double turn = 30 * std::exp(-std::pow((mean_h - 275) / 25, 2));
  const double from_middle = (mean_l - 50) * (mean_l - 50);
  const double l = delta_l / (1 + 0.015 * from_middle / std::sqrt(20 + from_middle));
  const double c = delta_c / (1 + 0.045 * mean_c_prime);
  const double h = delta_h / (1 + 0.015 * mean_c_prime * t);
  const double r_t = -std::sin(2 * turn * M_PI / 180) * 2 * seventh(mean_c_prime);
  return std::sqrt(l * l + c * c + h * h + r_t * c * h);
}

}  // namespace ulf
