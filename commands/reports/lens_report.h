// What a refinement found out about a lens, for people.
#pragma once

#include <string>

#include "core/geometry/camera_model.h"
#include "tracking/estimation/lens_evidence.h"

namespace ulf::commands {

// `given`: the lens as the light field had it. Where the images support another one that shows everything
// within half a pixel of where this one does, there is nothing to do, and it says so.
std::string LensFitText(const tracking::LensEstimate& fit, const CameraModel& given, bool is_taken_over);

// Where the fitted focal length is farther from that of before than its deviation accounts for: by how much,
// where the one of before was from (`source`; empty: not told), which of the two is kept, and why. Else
// empty.
std::string LensApartText(const tracking::LensEstimate& fit, const CameraModel& given,
                          const std::string& source, bool is_taken_over);

// What the deviations of lenses that images gave leave out.
inline constexpr const char* kLensSigmaWords =
    "± counts the noise of points alone: what a rolling shutter, blur and the lens model add is not in it; "
    "ulf calibrate with a printed board knows better";

}  // namespace ulf::commands
