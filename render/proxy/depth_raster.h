// Triangles drawn into a depth map, plainly: what the graphics pipeline does for a pinhole camera, at pixel
// centres, both sides of every triangle.
#pragma once

#include <opencv2/core.hpp>

#include "core/geometry/camera_model.h"
#include "core/geometry/rigid3.h"
#include "render/proxy/triangle_mesh.h"

namespace ulf::render {

// CV_32F, 1 / (depth along the optical axis), which is linear in the image over a triangle; 0 where there is
// none. `camera` is without distortion.
cv::Mat DrawInverseDepth(const TriangleMesh& mesh, const CameraModel& camera, const Rigid3& cam_from_world);

// What is 0 takes what is around it, by a pyramid of halved pictures (Gortler et al. 1996, pull and push):
// each level is the mean of what is known of the finer one, and fills it where it knows nothing. In place.
void FillHoles(cv::Mat& inverse_depth);

}  // namespace ulf::render
