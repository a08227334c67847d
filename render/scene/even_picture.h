// A view's photograph as programs without lenses and exposures need it: without distortion, on the scene's
// common scale of light, in 8-bit sRGB.
#pragma once

#include <opencv2/core.hpp>

#include "core/image/undistortion.h"
#include "render/scene/scene.h"

namespace ulf::render {

// Returns how the view is undistorted: not at all if it has no distortion, wherever its principal point lies.
// Throws Error if its axis is outside its picture.
Undistortion UndistortionOf(const SceneView& view);

// Returns CV_8UC3, or CV_8UC4 with alpha if some of the picture has no light, of the size of `camera`, which
// is `undistortion.to`, or that scaled down.
cv::Mat EvenPicture(const SceneView& view, const Undistortion& undistortion, const CameraModel& camera);

}  // namespace ulf::render
