// Samples points of the proxy's surface as the views that see them have recorded them.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "render/quality/light_solution.h"
#include "render/scene/scene.h"

namespace ulf::render {

Eigen::Vector2d HalfDiagonal(const CameraModel& camera);  // px, from a corner to the middle

// Returns the samples of the channels of all points; a fifth of the points is held out. `camera_of` has the
// number of each view's camera; `points` receives the number of points. The result does not depend on the
// number of threads; it is empty over a proxy without triangles.
std::vector<LightSample> SampleLight(const RenderScene& scene, const std::vector<int>& camera_of,
                                     std::size_t& points);

}  // namespace ulf::render
