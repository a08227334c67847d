// Triangles drawn into a depth map, plainly: what the graphics pipeline does for a pinhole camera, at pixel
// centres, both sides of every triangle.
#pragma once

#include <opencv2/core.hpp>

#include "acquisition/camera_model.h"
#include "acquisition/rigid3.h"
#include "render/triangle_mesh.h"

namespace ulf {

// CV_32F, 1 / (depth along the optical axis), which is linear in the image over a triangle; 0 where there is
// none. `camera` is without distortion.
cv::Mat DrawInverseDepth(const TriangleMesh& mesh, const CameraModel& camera, const Rigid3& cam_from_world);

}  // namespace ulf
