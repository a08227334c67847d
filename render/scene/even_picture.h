// A view's photograph on the scene's common scale of light: a colour of it, and the whole as programs without
// lenses and exposures need it, without distortion, in 8-bit sRGB.
#pragma once

#include <opencv2/core.hpp>

#include "core/image/undistortion.h"
#include "render/scene/scene.h"

namespace ulf::render {

// Returns the photograph's linear light, B G R, at a point of its image, on the common scale.
cv::Vec3f OnCommonScale(const SceneView& view, const cv::Vec3f& light, const Eigen::Vector2d& img);

// Returns how the view is undistorted: not at all if it has no distortion, wherever its principal point lies.
// Throws Error if its axis is outside its picture.
Undistortion UndistortionOf(const SceneView& view);

// Returns CV_8UC3, or CV_8UC4 with alpha if some of the picture has no light, of the size of `camera`, which
// is `undistortion.to`, or that scaled down.
cv::Mat EvenPicture(const SceneView& view, const Undistortion& undistortion, const CameraModel& camera);

}  // namespace ulf::render
