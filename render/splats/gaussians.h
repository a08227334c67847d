// A scene as Gaussians ("splats"; Kerbl et al. 2023, "3D Gaussian splatting for real-time radiance field
// rendering"), which other programs show from any viewpoint.
//
// A picture lays the Gaussians over each other from near to far, in display-encoded sRGB. The colour of one
// is 0.5 + the sum of its spherical harmonics of degree 0 and 1, of the direction from the camera to it, not
// below 0.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <vector>

namespace ulf::render {

struct Gaussian {
  using Rotation = Eigen::Quaternion<float, Eigen::DontAlign>;

  Eigen::Vector3f position_in_world = Eigen::Vector3f::Zero();
  Rotation world_from_axes = Rotation::Identity();  // unit, w not negative
  Eigen::Vector3f scale = Eigen::Vector3f::Zero();  // standard deviations along its axes, world units
  float opacity = 0;                                // 0 to 1
  // R G B, as HarmonicsAt() orders them.
  std::array<Eigen::Vector3f, 4> harmonics{Eigen::Vector3f::Zero(), Eigen::Vector3f::Zero(),
                                           Eigen::Vector3f::Zero(), Eigen::Vector3f::Zero()};
};
using Gaussians = std::vector<Gaussian>;

// The constant harmonic, and the factor of those of degree 1: sqrt(1 / (4 pi)), sqrt(3 / (4 pi)).
inline constexpr float kConstantHarmonic = 0.28209479177387814f, kLinearHarmonic = 0.4886025119029199f;

// Returns the harmonics of a unit direction in the world, in the order and with the signs of trainers' files.
inline Eigen::Vector4f HarmonicsAt(const Eigen::Vector3f& direction) {
  return {kConstantHarmonic, -kLinearHarmonic * direction.y(), kLinearHarmonic * direction.z(),
          -kLinearHarmonic * direction.x()};
}

// Returns R G B, display-encoded, 0 to 1 and above.
inline Eigen::Vector3f ColorOf(const Gaussian& gaussian, const Eigen::Vector4f& harmonics) {
  Eigen::Vector3f color = Eigen::Vector3f::Constant(0.5f);
  for (int i = 0; i < 4; ++i) color += harmonics[i] * gaussian.harmonics[static_cast<std::size_t>(i)];
  return color.cwiseMax(0);
}

}  // namespace ulf::render
