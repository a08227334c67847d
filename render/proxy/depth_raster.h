// Draws triangles into a depth map on the processor, as the graphics pipeline does it: a pinhole camera,
// depths at pixel centres, both sides of every triangle.
#pragma once

#include <opencv2/core.hpp>

#include "core/geometry/camera_model.h"
#include "core/geometry/rigid3.h"
#include "render/proxy/triangle_mesh.h"

namespace ulf::render {

// A triangle is clipped where it is nearer to the camera than this share of its farthest corner's depth:
// projections of points at depth 0 are infinite. Guessed.
inline constexpr double kNearShare = 1e-4;

// Returns CV_32F, 1 / (depth along the optical axis), which is linear in the image over a triangle; 0 without
// a triangle. `camera` must be without distortion.
cv::Mat DrawInverseDepth(const TriangleMesh& mesh, const CameraModel& camera, const Rigid3& cam_from_world);

// Fills pixels of 0 from the pixels around them, in place: pull and push over a pyramid of halved images
// (Gortler et al. 1996). Each level is the mean of the finer one's known pixels, and fills the others.
void FillHoles(cv::Mat& inverse_depth);

}  // namespace ulf::render
