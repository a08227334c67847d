// The homography from a view's image to a neighbour's by a plane that is parallel to the view's image:
// (at_infinity + inverse_depth * [0 0 per_inverse_depth]) (x, y, 1), up to scale; pixels to pixels.
#pragma once

#include <Eigen/Core>

#include "render/stereo/stereo_view.h"

namespace ulf::render {

struct PlaneCarrier {
  Eigen::Matrix3f at_infinity;
  Eigen::Vector3f per_inverse_depth;
};

PlaneCarrier MakePlaneCarrier(const StereoView& view, const StereoView& neighbour);

}  // namespace ulf::render
