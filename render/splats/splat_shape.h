// The shape of a Gaussian that stands for a cell of a picture.
//
// Opaque Gaussians so large that they close a surface blur it: neighbours cover each other, in an order that
// changes with the view, which no choice of colours undoes. Therefore a surface has two layers. The ground,
// opaque and without gaps, has large cells. Small, half transparent Gaussians before it add the detail; where
// a view comes nearer, so that they no longer touch, the ground shows between them.
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>

#include "render/splats/gaussians.h"

namespace ulf::render {

struct SplatForm {
  float spread;  // standard deviation over the size of the cell, as drawn from the view, low-pass included
  float opacity;
};
// A hundredth shines through where four cells of the ground meet; wider ones would reach over edges.
inline constexpr SplatForm kGroundForm{0.75f, 0.98f}, kDetailForm{0.57f, 0.6f};

// A cell of a picture on a surface.
struct SurfaceCell {
  Eigen::Vector3f point, across, down, normal;  // world: the middle, its two spans, the unit normal
  float size_px = 1;                            // in the pictures that are compared
  cv::Vec3b bgr;                                // 8-bit sRGB
};

// Returns a Gaussian that is flat along the surface, of the same colour in all directions.
Gaussian FlatGaussian(const SplatForm& form, const SurfaceCell& cell);

}  // namespace ulf::render
