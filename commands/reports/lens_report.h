// Reports a refined lens for people.
#pragma once

#include <string>

#include "core/geometry/camera_model.h"
#include "tracking/estimation/lens_evidence.h"

namespace ulf::commands {

// `given` is the lens of the light field. If the images support another one whose image points differ by less
// than half a pixel, nothing needs to be done, and the text says so.
std::string LensFitText(const tracking::LensEstimate& fit, const CameraModel& given, bool is_taken_over);

// If the fitted focal length differs from the former one by more than its deviation explains, says by how
// much, the former one's origin (`source`; empty: unknown), which of the two is kept, and why. Otherwise "".
std::string LensApartText(const tracking::LensEstimate& fit, const CameraModel& given,
                          const std::string& source, bool is_taken_over);

// States what the standard deviations of lenses estimated from images leave out.
inline constexpr const char* kLensSigmaWords =
    "± counts the noise of points alone: what a rolling shutter, blur and the lens model add is not in it; "
    "ulf calibrate with a printed board knows better";

}  // namespace ulf::commands
