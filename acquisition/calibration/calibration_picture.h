// Draws pictures of calibrations and of flat fields, to judge them by eye. All are CV_8UC3.
#pragma once

#include <opencv2/core.hpp>

#include "acquisition/calibration/calibrate.h"
#include "acquisition/calibration/calibration_guide.h"
#include "core/image/flat_field.h"

namespace ulf::acquisition {

// Draws on the left the residual of every corner as an arrow from its predicted position, magnified as
// labelled, over contours of the distortion in pixels; on the right the corners. Good residuals have random
// directions; a pattern (all inwards at the rim) means that the model does not fit the lens.
cv::Mat DrawCalibration(const CalibrationResult& result);

// Draws the light over the image with contour lines, and each channel's profile along the diagonal.
cv::Mat DrawFlatField(const FlatFieldResult& result);

// Draws what the operator sees while views are taken: the picture with the corners found in it, parts that no
// view covers yet in colour; below, what to do next, which edges of the board have been tilted away, and how
// much is done. `gray`: CV_8UC1, the picture that the guide has judged last. The result is 960 pixels wide.
cv::Mat DrawGuide(const cv::Mat& gray, const CalibrationGuide& guide, ViewVerdict verdict);

}  // namespace ulf::acquisition
