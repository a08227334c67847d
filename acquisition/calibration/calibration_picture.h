// Pictures of a calibration: residuals over the image, and coverage.
#pragma once

#include <opencv2/core.hpp>

#include "acquisition/calibration/calibrate.h"
#include "acquisition/calibration/calibration_guide.h"
#include "core/image/flat_field.h"

namespace ulf::acquisition {

// Left: the residual of every corner as an arrow from its predicted position, magnified as labelled, over
// contours of the distortion in pixels. Right: positions of the corners. Good residuals have random
// directions; a pattern (all inwards at the rim) means that the model does not fit the lens. CV_8UC3.
cv::Mat DrawCalibration(const CalibrationResult& result);

// Draws the light over the image with contour lines and the profile along the diagonal by colour. CV_8UC3.
cv::Mat DrawFlatField(const FlatFieldResult& result);

// Draws what the operator sees while views are taken: the picture with the corners found in it, parts that no
// view covers yet in colour; below, what to do next, which edges of the board have been tilted away, and how
// much is done. `gray`: CV_8UC1, the one that the guide has looked at last. CV_8UC3, 960 pixels wide.
cv::Mat DrawGuide(const cv::Mat& gray, const CalibrationGuide& guide, ViewVerdict verdict);

}  // namespace ulf::acquisition
