// A calibration to look at: what its residuals look like over the image, and what was covered.
#pragma once

#include <opencv2/core.hpp>

#include "acquisition/calibration/calibrate.h"
#include "core/image/flat_field.h"

namespace ulf::acquisition {

// Left: every corner's residual as an arrow from where it was predicted, magnified as written, over contours
// of the lens's distortion in pixels. Right: where corners were seen. Good residuals point everywhere; a
// pattern (all inwards at the rim) is a lens that the model does not follow. CV_8UC3.
cv::Mat DrawCalibration(const CalibrationResult& result);

// Left: the light over the image with lines of equal share; right: along the diagonal, B, G and R. CV_8UC3.
cv::Mat DrawFlatField(const FlatFieldResult& result);

}  // namespace ulf::acquisition
