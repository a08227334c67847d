// Takes pixels of a view to pixels of a neighbour by way of a plane that is parallel to the view's image:
// (at_infinity + inverse depth * [0 0 per_inverse_depth]) (x, y, 1), up to scale.
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
